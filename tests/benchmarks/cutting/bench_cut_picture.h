#pragma once
// What the subdivisions make of the same cut, side by side.

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

/// One lip of each cut and the elements behind it, four to a row at most: lips red, elements that the cut made or
/// changed yellow, others grey.
/// @param body as it was before. @throws IoError.
void write_cut_picture(const std::filesystem::path& file, const BenchBody& body, const std::vector<PicturedCut>& cuts);

} // namespace retractor::benchmarks
