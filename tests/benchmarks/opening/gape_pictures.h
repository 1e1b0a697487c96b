#pragma once
// Pictures of a wound on the thorax phantom under 2, 4 and 6 % tension, opened by springs, like fig. 10 of [Nakao and
// others 2006, doi 10.1007/s10916-006-9021-4].

#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::benchmarks {

struct GapePicture {
    double strain = 0.0;
    double gape_mm = 0.0; ///< widest distance between the lips of the skin
    double seconds = 0.0; ///< run time of the springs, s
    std::string status; ///< status of the springs
    std::filesystem::path file;
};

/// Writes gape-2.png, gape-4.png, gape-6.png, and gape.png with all three side by side.
/// @throws SolverError when cancelled.
std::vector<GapePicture> draw_gapes(const std::filesystem::path& folder, const Job& job);

} // namespace retractor::benchmarks
