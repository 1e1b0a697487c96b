#pragma once
// Items of persons from a table of examinations over years, for association rules.
//
// A CSV file with a header: a column `person`, optionally a column `year`, exposures (numbers), and findings (0 or 1;
// empty counts as 0). Of each person the record of the earliest year counts: our reading of "each people's oldest year"
// (Katsumura, Shinohara, Matsumoto, Imamura, Oyama). A finding is an item of those who have it; who does not have it
// has no item.
// An exposure is high in the upper third of the persons, and low in the lower; those between have no item. The
// exposures together are one item, "A_B_C (High_Low_High)", of persons in whom each of them is high or low.

#include "datasets/tables/csv_reader.h"
#include "mesh/base/job.h"
#include "planner/evidence/association_rules.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::planner {

struct PersonTable {
    std::string person_column = "person", year_column = "year";
    std::vector<std::string> exposures {}; ///< columns with numbers; empty: all columns are findings
    bool separate = false; ///< exposures are items one by one, too
    bool skip_bad = false; ///< rows that are wrong are left out
};

struct PersonItems {
    ItemTable table;
    std::size_t records = 0; ///< rows that were right
    datasets::BadRows bad; ///< rows that were left out
};

/// Exposures stand on the left side and findings on the right; without exposures every finding may stand on either.
/// @throws InputError on a column that is missing or named twice, on rows that are wrong unless they are left out, and
/// on an exposure with too few different numbers for thirds; IoError
PersonItems read_person_items(const std::filesystem::path& file, const PersonTable& described, const Job& job = {});

/// The largest number of the lower third and the smallest of the upper: ceil(n / 3) numbers lie in each, and equal
/// ones.
struct Tertiles {
    double low = 0.0, high = 0.0;
};
/// @throws InputError when both thirds would hold the same number. @pre not empty, finite
Tertiles tertiles_of(std::vector<double> numbers);

} // namespace retractor::planner
