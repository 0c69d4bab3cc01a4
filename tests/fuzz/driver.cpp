// Stands in for libFuzzer where the compiler has none: mutates the corpus without looking at coverage, from a
// fixed seed, so that every run sees the same bytes.
//   PHIZ_FUZZ_TARGET=ply phiz_fuzz CORPUS_FOLDER [--seconds N] [--runs N] [--seed N]
// What it was given last lies in ./phiz-fuzz-last when it ends otherwise than with code 0. Memory that is not
// given back is a finding too: the heap in use at the end is compared with that after the first inputs.

#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/random.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

constexpr unsigned kSecondsAnInput = 20;
constexpr std::size_t kMaxBytes = 1 << 20;
constexpr std::uint64_t kMaxMemoryBytes = std::uint64_t{4} << 30;
constexpr std::uint64_t kWarmUpRuns = 20'000;
constexpr std::int64_t kMaxHeapGrowthBytes = 1 << 20;  // caches of libraries, not one block a run

std::string current;  // what is being read

extern "C" void keep_and_end(int signal) {
  std::ofstream("phiz-fuzz-last", std::ios::binary) << current;
  std::cerr << "signal " << signal << (signal == SIGALRM ? ": took too long" : "") << "\n";
  ::_exit(128 + signal);
}

std::vector<std::string> read_corpus(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) corpus.emplace_back();
  return corpus;
}

class Mutator {
 public:
  Mutator(const std::vector<std::string>& corpus, std::uint64_t seed) : corpus_(corpus), random_(seed) {}

  std::string next() {
    std::string bytes = corpus_[random_.below(corpus_.size())];
    for (std::uint64_t i = 0, count = 1 + random_.below(4); i < count; ++i) change(bytes);
    if (bytes.size() > kMaxBytes) bytes.resize(kMaxBytes);
    return bytes;
  }

 private:
  std::size_t place(const std::string& bytes) { return random_.below(bytes.size()); }
  std::size_t length(const std::string& bytes, std::size_t at) {
    return 1 + random_.below(std::min<std::size_t>(bytes.size() - at, 64));
  }

  void change(std::string& bytes) {
    if (bytes.empty()) {
      bytes.push_back(static_cast<char>(random_.below(256)));
      return;
    }
    const std::size_t at = place(bytes);
    switch (random_.below(9)) {
      case 0:
        bytes[at] ^= static_cast<char>(1 << random_.below(8));
        return;
      case 1:
        bytes[at] = static_cast<char>(random_.below(256));
        return;
      case 2:
        bytes.resize(at);
        return;
      case 3:
        bytes.erase(at, length(bytes, at));
        return;
      case 4:
        bytes.insert(at, bytes.substr(at, length(bytes, at)));
        return;
      case 5:
        put_number(bytes, at);
        return;
      case 6:
        put_text(bytes, at);
        return;
      case 7: {
        const std::string& other = corpus_[random_.below(corpus_.size())];
        if (!other.empty()) bytes = bytes.substr(0, at) + other.substr(random_.below(other.size()));
        return;
      }
      default:
        std::swap(bytes[at], bytes[place(bytes)]);
    }
  }

  /// A count or an offset that is far too large, or nearly right.
  void put_number(std::string& bytes, std::size_t at) {
    constexpr std::uint64_t kNumbers[] = {0,          1,           0x7f,      0x80,       0xff,
                                          0x7fff,     0xffff,      0x10000,   0x7fffffff, 0x80000000,
                                          0xffffffff, 0x100000000, UINT64_MAX};
    std::uint64_t number = kNumbers[random_.below(std::size(kNumbers))];
    for (std::size_t i = 0, size = std::size_t{1} << random_.below(4); i < size && at + i < bytes.size();
         ++i) {
      bytes[at + i] = static_cast<char>(number & 0xff);
      number >>= 8;
    }
  }

  void put_text(std::string& bytes, std::size_t at) {
    static const std::vector<std::string> kTexts = {"-1",       "0",         "99999999999999999999",
                                                    "1e999",    "-1e-999",   "nan",
                                                    "inf",      "\"",        "{",
                                                    "}",        "[",         "]",
                                                    "[[[[[[[[", "../",       "\n",
                                                    "\r\n",     " ",         ",",
                                                    "\\u0000",  "null",      "true",
                                                    "//",       "/0",        "#",
                                                    "\xff\xfe", "4294967296"};
    const std::string& text = kTexts[random_.below(kTexts.size())];
    if (random_.below(2) == 0) {
      bytes.insert(at, text);
    } else {
      bytes.replace(at, std::min(text.size(), bytes.size() - at), text);
    }
  }

  const std::vector<std::string>& corpus_;
  phiz::test::Random random_;
};

struct Arguments {
  fs::path corpus;
  double seconds = 3;
  std::uint64_t runs = UINT64_MAX, seed = 1;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--seconds") {
      arguments.seconds = std::atof(value), ++i;
    } else if (word == "--runs") {
      arguments.runs = std::strtoull(value, nullptr, 10), ++i;
      arguments.seconds = 1e9;
    } else if (word == "--seed") {
      arguments.seed = std::strtoull(value, nullptr, 10), ++i;
    } else {
      arguments.corpus = word;
    }
  }
  return arguments;
}

void read_one(const std::string& bytes) {
  current = bytes;
  ::alarm(kSecondsAnInput);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current.data()), current.size());
  ::alarm(0);
}

std::int64_t heap_in_use() {
#if defined(__SANITIZE_ADDRESS__)
  return 0;  // it looks for leaks itself
#else
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
#endif
}

struct Ran {
  std::uint64_t runs = 0;
  double seconds = 0;
  std::int64_t heap_growth_bytes = 0;  // since the warm-up; 0 for shorter runs
};

Ran run(const Arguments& arguments) {
  const std::vector<std::string> corpus = read_corpus(arguments.corpus);
  for (const std::string& bytes : corpus) read_one(bytes);
  Mutator mutator(corpus, arguments.seed);
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  Ran ran{corpus.size()};
  std::int64_t heap_at_first = 0;
  for (; ran.runs < arguments.runs && elapsed() < arguments.seconds; ++ran.runs) {
    read_one(mutator.next());
    if (ran.runs == kWarmUpRuns) heap_at_first = heap_in_use();
  }
  ran.seconds = elapsed();
  current = {};
  if (ran.runs > kWarmUpRuns) ran.heap_growth_bytes = heap_in_use() - heap_at_first;
  return ran;
}

}  // namespace

int main(int argc, char** argv) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGALRM}) ::signal(signal, keep_and_end);
#if !defined(__SANITIZE_ADDRESS__)
  const rlimit memory{kMaxMemoryBytes, kMaxMemoryBytes};
  ::setrlimit(RLIMIT_AS, &memory);  // who allocates by a header's word alone, fails
#endif
  try {
    const Ran ran = run(parse(argc, argv));
    std::cout << ran.runs << " runs, " << ran.seconds << " s, heap grew by " << ran.heap_growth_bytes
              << " bytes\n";
    return ran.heap_growth_bytes > kMaxHeapGrowthBytes ? 1 : 0;
  } catch (const std::exception& error) {
    std::ofstream("phiz-fuzz-last", std::ios::binary) << current;
    std::cerr << "a reader let through: " << error.what() << "\n";
    return 1;
  }
}
