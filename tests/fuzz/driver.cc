// Fuzzes a reader without clang: with its corpus and with mutations of it that a seed determines.
//
//   reader_fuzz READER CORPUS_FOLDER --runs N | --seconds S [--seed K]
//
// The seed is that of the variable SKYWAVE_FUZZ_SEED if there is none here, else 1: CI takes that
// of the commit. Prints the seed and the number of each run. After a failure, `--seed K --only RUN`
// reads the same input again, and prints it.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "base/files.h"
#include "tests/fuzz/readers.h"

namespace skywave {
namespace {

using Random = std::uint64_t;

// splitmix64 (Steele, Lea and Flood 2014).
std::uint64_t Next(Random& state) {
  std::uint64_t z = state += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}
std::size_t Below(Random& state, std::size_t n) { return n == 0 ? 0 : Next(state) % n; }

constexpr const char* kTokens[] = {"0",   "-1", "1e39", "nan", "4294967296", "[",  "]", "\"",
                                   "{",   "}",  ",",    "#",   "\n",         " ",  "/", "../",
                                   "999", ".5", "\\",   ":",   "2147483647", "-0", "f", "\x1f\x8b"};

std::string MutateOnce(std::string bytes, const std::vector<std::string>& corpus, Random& random) {
  const std::size_t at = Below(random, bytes.size() + 1);
  const std::size_t length = 1 + Below(random, std::min<std::size_t>(bytes.size() - at + 1, 32));
  switch (Below(random, 7)) {
    case 0:  // flip a bit
      if (at < bytes.size()) bytes[at] = char(bytes[at] ^ (1 << Below(random, 8)));
      return bytes;
    case 1:  // replace a byte
      if (at < bytes.size()) bytes[at] = char(Below(random, 256));
      return bytes;
    case 2:  // truncate
      return bytes.substr(0, at);
    case 3:  // erase
      return bytes.erase(at, length);
    case 4:  // repeat, and thereby nest
      return bytes.insert(at, bytes.substr(at, length));
    case 5:
      return bytes.insert(at, kTokens[Below(random, std::size(kTokens))]);
    default: {  // splice
      const std::string& other = corpus[Below(random, corpus.size())];
      return bytes.substr(0, at) + other.substr(Below(random, other.size() + 1));
    }
  }
}

std::string Input(const std::vector<std::string>& corpus, std::uint64_t seed, std::uint64_t run) {
  if (run < corpus.size()) return corpus[run];
  Random random = seed * 0x2545F4914F6CDD1Du + run;
  std::string bytes = corpus[Below(random, corpus.size())];
  for (std::size_t i = 0, n = 1 + Below(random, 5); i < n; ++i) {
    bytes = MutateOnce(std::move(bytes), corpus, random);
  }
  return bytes;
}

int Main(int count, char** words) {
  const std::vector<std::string> arguments(words + 1, words + count);
  const auto option = [&](const char* name, double otherwise) {
    const auto found = std::find(arguments.begin(), arguments.end(), name);
    return found < arguments.end() - 1 ? std::atof((found + 1)->c_str()) : otherwise;
  };
  const auto readers = FuzzedReaders();
  const auto reader = std::find_if(readers.begin(), readers.end(), [&](const auto& r) {
    return !arguments.empty() && r.name == arguments[0];
  });
  if (arguments.size() < 2 || reader == readers.end()) {
    std::fprintf(stderr, "reader_fuzz READER CORPUS_FOLDER --runs N | --seconds S [--seed K]\n");
    return 64;
  }
  std::vector<std::string> names, corpus;
  for (const auto& entry : std::filesystem::directory_iterator(arguments[1])) {
    names.push_back(entry.path().string());
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) corpus.push_back(ReadFile(name));
  if (corpus.empty()) {
    std::fprintf(stderr, "%s is empty\n", arguments[1].c_str());
    return 65;
  }

  const char* const given_seed = std::getenv("SKYWAVE_FUZZ_SEED");
  const auto seed =
      std::uint64_t(option("--seed", given_seed == nullptr ? 1 : std::atof(given_seed)));
  if (const double only = option("--only", -1); only >= 0) {
    const std::string input = Input(corpus, seed, std::uint64_t(only));
    std::fwrite(input.data(), 1, input.size(), stdout);
    std::fflush(stdout);
    FuzzOnce(*reader, input);
    return 0;
  }
  const double seconds = option("--seconds", 1e9);
  const auto runs = std::uint64_t(option("--runs", 1e18));
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t run = 0;
  const char* const reader_name = words[1];
  std::fprintf(stderr, "if a run fails: reader_fuzz %s %s --seed %llu --only RUN > INPUT\n",
               reader_name, words[2], static_cast<unsigned long long>(seed));
  for (; run < runs; ++run) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    if (spent.count() > seconds) break;
    // The line stays on the terminal if this run ends the program.
    std::fprintf(stderr, "\r%s run %llu", reader_name, static_cast<unsigned long long>(run));
    try {
      FuzzOnce(*reader, Input(corpus, seed, run));
    } catch (const std::exception& error) {
      std::fprintf(stderr, ": %s\n", error.what());
      return 1;
    }
  }
  std::fprintf(stderr, "\r%s: %llu runs\n", reader_name, static_cast<unsigned long long>(run));
  return 0;
}

}  // namespace
}  // namespace skywave

int main(int count, char** words) { return skywave::Main(count, words); }
