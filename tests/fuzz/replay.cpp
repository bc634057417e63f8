// Replaces libFuzzer under any compiler: replays a corpus folder, then a fixed number of mutations of it.
//   NAME_fuzz CORPUS_FOLDER MUTATIONS
// The same arguments give the same inputs. An input that fails is saved as failed.input.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t kMaxBytes = 1 << 16;

std::vector<Input> readCorpus(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<Input> corpus;
    for (const auto& file : files) {
        std::ifstream in(file, std::ios::binary);
        corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    return corpus;
}

class Mutator {
  public:
    Input mutate(const std::vector<Input>& corpus) {
        Input input = corpus[below(corpus.size())];
        for (std::size_t n = 1 + below(4); n > 0; --n)
            change(input, corpus);
        if (input.size() > kMaxBytes) input.resize(kMaxBytes);
        return input;
    }

  private:
    std::size_t below(std::size_t count) { return count == 0 ? 0 : std::size_t(random_() % count); }

    void change(Input& input, const std::vector<Input>& corpus) {
        const std::size_t at = below(input.size());
        const auto here = input.begin() + std::ptrdiff_t(at);
        switch (below(6)) {
            case 0:
                if (!input.empty()) input[at] ^= std::uint8_t(1u << below(8));
                break;
            case 1:
                putExtreme(input, at);
                break;
            case 2:
                input.resize(at);
                break;
            case 3:
                input.erase(here, here + std::ptrdiff_t(below(std::min<std::size_t>(input.size() - at, 64))));
                break;
            case 4:
                input.insert(here, 1 + below(16), std::uint8_t(random_()));
                break;
            default: {  // a piece of another input
                const Input& other = corpus[below(corpus.size())];
                const std::size_t from = below(other.size()),
                                  count = below(std::min<std::size_t>(other.size() - from, 64));
                input.insert(here, other.begin() + std::ptrdiff_t(from),
                             other.begin() + std::ptrdiff_t(from + count));
            }
        }
    }
    // Writes a common limit value as one, two or four bytes.
    void putExtreme(Input& input, std::size_t at) {
        constexpr std::uint32_t kExtremes[] = {0,          1,          0x7f,       0x80,       0xff,
                                               0x7fff,     0x8000,     0xffff,     1025,       0x7fffffff,
                                               0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000, 0x00000001};
        const std::uint32_t value = kExtremes[below(std::size(kExtremes))];
        const std::size_t bytes = std::size_t(1) << below(3);
        for (std::size_t i = 0; i < bytes && at + i < input.size(); ++i)
            input[at + i] = std::uint8_t(value >> (8 * i));
    }

    std::mt19937_64 random_{20260712};
};

bool survives(const Input& input) {
    try {
        LLVMFuzzerTestOneInput(input.data(), input.size());
        return true;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "not refused properly: %s\n", e.what());
    }
    std::ofstream("failed.input", std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), std::streamsize(input.size()));
    return false;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: %s CORPUS_FOLDER MUTATIONS\n", argv[0]);
        return 2;
    }
    const std::vector<Input> corpus = readCorpus(argv[1]);
    if (corpus.empty()) {
        std::fprintf(stderr, "%s: no corpus\n", argv[1]);
        return 2;
    }
    for (const Input& input : corpus)
        if (!survives(input)) return 1;
    Mutator mutator;
    const long count = std::atol(argv[2]);
    for (long i = 0; i < count; ++i)
        if (!survives(mutator.mutate(corpus))) return 1;
    std::printf("%zu inputs and %ld mutations\n", corpus.size(), count);
    return 0;
}
