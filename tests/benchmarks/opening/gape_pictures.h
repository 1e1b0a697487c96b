#pragma once
// A wound on the thorax phantom under 2, 4 and 6 % tension, opened by springs: pictures like the source's fig. 10.

#include "ui/cli/framework/command.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::benchmarks {

struct GapePicture {
    double strain = 0.0;
    double gape_mm = 0.0; ///< widest distance between the lips of the skin
    double seconds = 0.0; ///< of the springs
    std::string status; ///< of the springs
    std::filesystem::path file;
};

/// gape-2.png, gape-4.png, gape-6.png and gape.png with the three side by side.
/// @throws SolverError when cancelled.
std::vector<GapePicture> draw_gapes(const std::filesystem::path& folder, const Job& job);

} // namespace retractor::benchmarks
