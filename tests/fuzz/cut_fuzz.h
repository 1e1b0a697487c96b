#pragma once
// One seed of the cut fuzzer: a session on a body, some random strokes with undo and redo between them, every
// invariant after each, and what the strokes cost in quality.

#include "tests/fuzz/cut_bodies.h"
#include "tests/fuzz/cut_invariants.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace retractor::fuzz {

inline constexpr std::array<double, 4> kSnaps { 0.0, 0.15, 0.35, 0.5 };
inline constexpr int kStrokesPerSeed = 5;

/// Counts of the strokes of one body at one snap.
struct Tally {
    std::size_t strokes = 0, done = 0, missed = 0;
    std::size_t refused_steps = 0; ///< of freehand strokes: the point is left out
    std::map<std::string, std::size_t> refused; ///< by reason
    std::map<int, std::size_t> attempts; ///< strokes that were done, by how many attempts they took
    std::size_t ablations = 0, ablated = 0; ///< done; elements
    std::map<std::string, std::size_t> broken; ///< by invariant
    double crossed = 0.0, increase = 0.0, seconds = 0.0;
    double slowest = 0.0; ///< processor time (s) of a stroke, or a freehand step, refused or not
    std::vector<double> worst, p01; ///< dihedral angles (degrees), one per stroke that was done
    std::size_t born = 0; ///< elements
    /// Elements below 5 degrees, by what holds their vertices: "wound" (a corner on an earlier wound), "thin"
    /// (all four on surfaces, interfaces or the blade), "surface" (some on a surface or an interface), "free".
    std::map<std::string, std::size_t> flat;
    void add(const Tally& other);
};

struct SeedResult {
    Tally tally;
    std::vector<std::string> refusals; ///< likewise
    std::vector<std::string>
        slow; ///< strokes and freehand steps of a second or more (processor time), or of four attempts: likewise
    std::vector<std::string> failures; ///< "stroke 2 (kinked, snap 0.35): invariant: detail"
};

/// With every sixth seed tissue is ablated too. The snap of a seed is kSnaps[seed % 4]. With `twice` everything is done
/// twice and must give the same bits.
SeedResult run_seed(const Body& body, std::uint64_t seed, bool twice);

} // namespace retractor::fuzz
