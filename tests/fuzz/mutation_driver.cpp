// A plain mutation fuzzer for compilers without libFuzzer: seeds from a folder, random changes, a fixed seed of the generator.
//   mutation_driver CORPUS_FOLDER -runs=N [-max_len=BYTES] [-max_total_time=SECONDS] [-seed=N]
// With -runs=0 the inputs of the folder are run as they are. An input that aborts is left in the file broken_input.
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes running;  // the input at work, for who wants to see what broke

void keep_input(int signal) {
  std::ofstream("broken_input", std::ios::binary)
      .write(reinterpret_cast<const char*>(running.data()), static_cast<std::streamsize>(running.size()));
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

std::uint64_t number_option(int count, char** arguments, const std::string& name, std::uint64_t otherwise) {
  for (int i = 2; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument.rfind(name, 0) == 0) return std::strtoull(argument.c_str() + name.size(), nullptr, 10);
  }
  return otherwise;
}

std::vector<Bytes> read_seeds(const std::string& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Bytes> seeds;
  for (const auto& path : paths) {
    std::ifstream in(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return seeds;
}

class Mutator {
 public:
  Mutator(std::uint64_t seed, std::size_t max_len) : random_(seed), max_len_(max_len) {}

  Bytes mutate(const std::vector<Bytes>& seeds) {
    Bytes bytes = seeds[below(seeds.size())];
    for (std::size_t change = 1 + below(6); change > 0; --change) apply(bytes, seeds[below(seeds.size())]);
    bytes.resize(std::min(bytes.size(), max_len_));
    return bytes;
  }

 private:
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : static_cast<std::size_t>(random_() % limit); }

  void apply(Bytes& bytes, const Bytes& other) {
    static constexpr std::array<std::uint32_t, 10> kTelling = {0, 1, 2, 13, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFACE};
    if (bytes.empty()) return;
    const std::size_t at = below(bytes.size());
    switch (below(8)) {
      case 0:
        bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(random_());
        break;
      case 2: {  // a number that tests limits, in a field of 1, 2 or 4 bytes
        const std::uint32_t value = kTelling[below(kTelling.size())];
        const std::size_t width = std::min<std::size_t>(std::size_t{1} << below(3), bytes.size() - at);
        for (std::size_t i = 0; i < width; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
        break;
      }
      case 3:  // the end is cut off
        bytes.resize(at);
        break;
      case 4: {  // a stretch is lost
        const std::size_t end = at + below(std::min<std::size_t>(bytes.size() - at, 600));
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin() + static_cast<std::ptrdiff_t>(end));
        break;
      }
      case 5: {  // a stretch of another log comes in
        const std::size_t from = below(other.size());
        const std::size_t count = std::min<std::size_t>(below(600), other.size() - from);
        const auto first = other.begin() + static_cast<std::ptrdiff_t>(from);
        if (bytes.size() + count <= max_len_)
          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), first, first + static_cast<std::ptrdiff_t>(count));
        break;
      }
      case 6: {  // a stretch is copied over another
        const std::size_t to = below(bytes.size());
        const std::size_t count = std::min(below(300), bytes.size() - std::max(at, to));
        std::memmove(bytes.data() + to, bytes.data() + at, count);
        break;
      }
      default: {  // noise
        const std::size_t end = std::min(bytes.size(), at + below(64));
        for (std::size_t i = at; i < end; ++i) bytes[i] = static_cast<std::uint8_t>(random_());
      }
    }
  }

  std::mt19937_64 random_;
  std::size_t max_len_;
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: %s CORPUS_FOLDER -runs=N [-max_len=BYTES] [-max_total_time=SECONDS] [-seed=N]\n", arguments[0]);
    return 2;
  }
  const std::vector<Bytes> seeds = read_seeds(arguments[1]);
  if (seeds.empty()) {
    std::fprintf(stderr, "%s: holds no seeds\n", arguments[1]);
    return 2;
  }
  std::uint64_t runs = number_option(count, arguments, "-runs=", 100000);
  const std::uint64_t longest_s = number_option(count, arguments, "-max_total_time=", 0);
  Mutator mutator(number_option(count, arguments, "-seed=", 1), number_option(count, arguments, "-max_len=", 65536));
  const auto start = std::chrono::steady_clock::now();
  const auto since = [](auto moment) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - moment).count(); };
  double slowest_s = 0.0;
  std::signal(SIGABRT, keep_input);
  for (const Bytes& seed : seeds) {
    running = seed;
    LLVMFuzzerTestOneInput(seed.data(), seed.size());
  }
  for (std::uint64_t run = 0; run < runs; ++run) {
    running = mutator.mutate(seeds);
    const auto before = std::chrono::steady_clock::now();
    LLVMFuzzerTestOneInput(running.data(), running.size());
    slowest_s = std::max(slowest_s, since(before));
    if (longest_s > 0 && since(start) > static_cast<double>(longest_s)) runs = run + 1;
  }
  const double total_s = since(start);
  std::printf("%llu runs in %.0f s, the slowest %.4f s\n", static_cast<unsigned long long>(runs), total_s, slowest_s);
  return slowest_s > 5.0 ? 1 : 0;
}
