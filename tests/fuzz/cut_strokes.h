#pragma once
// Random strokes, aimed at what is hard: faces, edges and vertices of the mesh, earlier cuts, interfaces, borders.

#include "mesh/cutting/cut_session.h"
#include "tests/fuzz/cut_bodies.h"
#include "tests/fuzz/cut_invariants.h"

#include <random>
#include <string>

namespace retractor::fuzz {

struct RandomStroke {
    std::string kind;
    mesh::Blade blade;
    bool freehand = false; ///< grows point by point
};

/// Every draw is made in a statement of its own, so that a seed means the same strokes with every compiler.
/// @param now the session's state.
/// @param last the stroke before this one; its line may be empty.
RandomStroke random_stroke(const Body& body, const mesh::CutSession& session, const State& now,
    const RandomStroke& last, std::mt19937_64& random);

} // namespace retractor::fuzz
