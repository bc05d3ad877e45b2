#!/bin/sh
# The Phoronix Test Suite runs this in the folder of the test, which is also $HOME. Sources come
# from its download cache; docs/benchmarks.md says how the archive is made.
tar -xzf skywave-0.1.0.tar.gz
cmake -S skywave-0.1.0 -B build -DCMAKE_BUILD_TYPE=Release
cmake --build build --target skywave -j "${NUM_CPU_CORES:-1}"
echo $? > ~/install-exit-status

cat > skywave-bench <<'END'
#!/bin/sh
cd ~ || exit 1
./build/skywave bench "$@" > "$LOG_FILE" 2>&1
echo $? > ~/test-exit-status
END
chmod +x skywave-bench
