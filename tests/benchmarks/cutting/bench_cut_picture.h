#pragma once
// Pictures of the same cut by different subdivisions, side by side.

#include "mesh/cutting/cut_session.h"
#include "tests/benchmarks/framework/bench_bodies.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::benchmarks {

struct PicturedCut {
    std::string title;
    std::vector<std::string> notes;
    mesh::CutMesh cut;
};

/// Draws one lip of each cut and the elements behind the lip, at most four cuts in a row: lips red, elements that the
/// cut made or changed yellow, other elements grey.
/// @param body the body before the cut.
/// @throws IoError when the file cannot be written.
void write_cut_picture(const std::filesystem::path& file, const BenchBody& body, const std::vector<PicturedCut>& cuts);

} // namespace retractor::benchmarks
