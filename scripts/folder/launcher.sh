#!/bin/sh
# Starts Skywave from the folder in which this file lies; scripts/build_folder.sh puts it there. What
# the loader would say in riddles, or the processor by a signal, is said in a sentence first.
refuse() {
  echo "skywave: $1" >&2
  exit 1
}
folder=$(dirname "$(readlink -f "$0")")
machine=$(uname -sm)
[ "$machine" = "Linux x86_64" ] || refuse "this folder is for Linux x86_64, and this is $machine"
glibc=$(getconf GNU_LIBC_VERSION 2>/dev/null) || glibc="a system without it"
number=${glibc#glibc }
minor=${number#2.}
case $glibc in
  "glibc 2."*) [ "${minor%%.*}" -ge @MINOR@ ] || refuse "this needs glibc 2.@MINOR@ or newer, and this is $glibc" ;;
  *) refuse "this needs glibc 2.@MINOR@ or newer, and this is $glibc" ;;
esac
grep -qsw avx2 /proc/cpuinfo || [ ! -r /proc/cpuinfo ] ||
  refuse "this needs a processor with AVX2, and $(sed -n 's/^model name[^:]*: //p;T;q' /proc/cpuinfo) has none"
# Names and sizes of all files below lib/.
if [ "$(cd "$folder/lib" 2>/dev/null && stat -c '%s %n' [!.]* 2>/dev/null)" != \
     "$(cat "$folder/lib/.sizes" 2>/dev/null)" ]; then
  [ -s "$folder/lib/.sizes" ] || refuse "$folder/lib/.sizes is missing; unpack the archive again"
  while read -r size name; do
    [ "$(stat -c %s "$folder/lib/$name" 2>/dev/null)" = "$size" ] ||
      refuse "$folder/lib/$name is missing or damaged; unpack the archive again"
  done < "$folder/lib/.sizes"
fi
exec "$folder/lib/skywave" "$@"
