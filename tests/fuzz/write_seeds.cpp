// Writes the corpora libFuzzer starts from: the seeds, and a few structured damages of each.
//   write_seeds FOLDER  ->  FOLDER/case, FOLDER/label_table

#include "mesh/base/atomic_file.h"
#include "tests/fuzz/fuzz_targets.h"
#include "tests/fuzz/mutations.h"

#include <cstdio>
#include <filesystem>

namespace {

void write_corpus(const std::filesystem::path& folder, const std::vector<std::string>& seeds)
{
    constexpr int kVariants = 100;
    std::filesystem::create_directories(folder);
    std::mt19937_64 random(1);
    for (std::size_t n = 0; n < seeds.size(); ++n) {
        const std::string stem = std::to_string(n);
        retractor::write_file_atomically(folder / (stem + ".json"), seeds[n]);
        for (int variant = 0; variant < kVariants; ++variant)
            retractor::write_file_atomically(folder / (stem + "-" + std::to_string(variant) + ".json"),
                retractor::fuzz::damage_values(seeds[n], random));
    }
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: write_seeds FOLDER\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    write_corpus(folder / "case", retractor::fuzz::case_seeds());
    write_corpus(folder / "label_table", retractor::fuzz::label_table_seeds());
    return 0;
}
