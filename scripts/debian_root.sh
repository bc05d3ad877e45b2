# These functions make small Debian systems in folders and run commands in them. Source this file.
#   need_roots
#   make_root RELEASE DIRECTORY [PACKAGE...]     RELEASE: bookworm, trixie
#   install_in_root DIRECTORY [--bind FROM TO]... PACKAGE...
#   in_root DIRECTORY [--bind FROM TO]... COMMAND [ARGUMENT...]
#   remove_root DIRECTORY
# Mirrors are those of the machine's own apt sources. Where a root cannot be made, need_roots and
# make_root print "skipped: REASON" and exit with 77.

# Prints apt sources for a release, one a line: the machine's own, with the name of its release
# replaced.
debian_sources() {
  local own
  own=$(. /etc/os-release && [[ $ID == debian ]] && echo "${VERSION_CODENAME:-}") || own=
  [[ -n $own ]] || { echo "skipped: this machine does not run a release of Debian" >&2; return 77; }
  # shellcheck disable=SC2016  # the fields are apt's
  apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    awk -v own="$own" -v release="$1" '
      $2 ~ "^" own "(-updates|-security)?$" && $3 == "main" {
        sub("^" own, release, $2)
        if (!seen[$0]++) print "deb", $1, $2, $3
      }'
}

# Ends the script where this machine or user cannot make roots.
need_roots() {
  [[ $(id -u) -eq 0 ]] || { echo "skipped: roots of Debian are made by root"; exit 77; }
  command -v mmdebstrap >/dev/null || { echo "skipped: mmdebstrap is not installed"; exit 77; }
  unshare --mount true 2>/dev/null || { echo "skipped: this container cannot mount"; exit 77; }
}

# Makes a system without compilers in DIRECTORY and installs the packages. A root of that release is
# kept if there is one, and gets the packages that it lacks.
make_root() {
  local release=$1 directory=$2 sources
  shift 2
  local packages=("$@")
  need_roots
  if [[ -f $directory.made && $(cat "$directory.made") == "$release" ]]; then
    if ! in_root "$directory" dpkg-query -W "${packages[@]}" >/dev/null 2>&1; then
      install_in_root "$directory" "${packages[@]}"
    fi
    return
  fi
  remove_root "$directory"
  sources=$(debian_sources "$release") || exit $?
  [[ -n $sources ]] || { echo "skipped: apt knows no mirror of Debian; run apt-get update"; exit 77; }
  mkdir -p "$(dirname "$directory")"
  echo "making a root of $release in $directory"
  mmdebstrap --quiet --mode=root --variant=minbase ${packages:+--include="${packages[*]}"} \
    "$release" "$directory" - <<< "$sources"
  # Written last, so that an interrupted root is not taken for a whole one.
  echo "$release" > "$directory.made"
}

# Installs packages, or files of packages that the root can see, with what they depend on.
install_in_root() {
  local options=("$1")
  shift
  while [[ ${1:-} == --bind ]]; do options+=("${@:1:3}"); shift 3; done
  in_root "${options[@]}" apt-get update -qq
  in_root "${options[@]}" apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

# Runs a command as root of the system in DIRECTORY, which sees folders FROM of this machine as TO.
# Only this command sees the mounts, and they end with it, so nothing can be left mounted.
in_root() {
  local directory=$1 mounts=()
  shift
  while [[ ${1:-} == --bind ]]; do mounts+=("$2" "$3"); shift 3; done
  # shellcheck disable=SC2016  # the inner shell expands them
  unshare --mount --pid --fork --kill-child bash -c '
    set -e
    directory=$1 count=$2
    shift 2
    # Programs that enter a name space of their own expect a mount at their "/".
    mount --bind "$directory" "$directory"
    mount -t proc proc "$directory/proc"
    mount --rbind /dev "$directory/dev"
    mount --rbind /sys "$directory/sys"
    mount --bind /etc/resolv.conf "$directory/etc/resolv.conf" 2>/dev/null || true
    for ((; count > 0; count -= 2)); do
      mkdir -p "$directory$2"
      mount --bind "$1" "$directory$2"
      shift 2
    done
    exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 TERM=dumb \
      DEBIAN_FRONTEND=noninteractive chroot "$directory" "$@"
  ' in_root "$directory" "${#mounts[@]}" "${mounts[@]}" "$@"
}

remove_root() {
  rm -rf --one-file-system "$1" "$1.made"
}
