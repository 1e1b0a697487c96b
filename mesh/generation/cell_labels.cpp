#include "mesh/generation/cell_labels.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>

namespace retractor::mesh {

namespace {

    // Weight of interface area against misfit volume (mm). The length smooths an interface that single cells crumple,
    // and is far below the thickness of a layer with cells of its own.
    constexpr double kAreaLength = 0.7;
    // Cells outside the body with a smaller angle (degrees) are no pits, and refinement has not controlled their shape.
    constexpr double kFlattestAdded = 8.0;
    // Cells with a smaller angle (degrees) get the label that smooths the interface, because their small content counts
    // less.
    constexpr double kFlattestFilled = 15.0;
    constexpr double kFlatWeight = 0.1;
    constexpr int kMostSweeps = 20;
    constexpr double kLeastGain = 1e-6; ///< mm^3, far above round-off: sums that only swap do not go on for ever

    std::size_t u(std::int64_t i) { return static_cast<std::size_t>(i); }

    struct Cell {
        std::size_t number;
        double volume; ///< volume that counts as misfit
        std::array<double, 4> areas;
        std::array<int, kCellSamples.size()> samples;
        bool flat;
    };

    class Fit {
    public:
        Fit(LabelledCells& cells, const LabelField& field)
            : cells_(cells)
            , field_(field)
        {
            RETRACTOR_ASSERT(cells.neighbours.size() == cells.tets.size() && cells.labels.size() == cells.tets.size());
            candidate_.assign(cells_.tets.size(), -1);
        }

        void run()
        {
            int rounds = 0;
            do
                improve_cells();
            while (improve_pairs() && ++rounds < kMostSweeps);
        }

    private:
        void improve_cells()
        {
            for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
                bool changed = false;
                for (std::size_t c = 0; c < cells_.tets.size(); ++c)
                    if (near_interface(c))
                        changed |= improve(candidate(c));
                if (!changed)
                    return;
            }
        }

        /// Pits and spikes of two cells, where changing the first of them alone would cost more area than it gains.
        bool improve_pairs()
        {
            bool changed = false;
            for (std::size_t c = 0; c < cells_.tets.size(); ++c) {
                if (!near_interface(c))
                    continue;
                for (const TetId n : cells_.neighbours[c])
                    if (n >= 0)
                        for (std::size_t i = 0; i < 4; ++i)
                            if (const int other = beyond(c, i); other != cells_.labels[c])
                                changed |= change({ c, u(n) }, other);
            }
            return changed;
        }

        /// Gives two cells another label where they have the same and this lowers the sum.
        bool change(const std::array<std::size_t, 2>& pair, int label)
        {
            if (cells_.labels[pair[0]] != cells_.labels[pair[1]] || must_stay(pair[0]) || must_stay(pair[1])
                || gain(pair, label) <= kLeastGain)
                return false;
            for (const std::size_t cell : pair)
                cells_.labels[cell] = static_cast<std::uint8_t>(label);
            return true;
        }

        bool must_stay(std::size_t c) { return cells_.labels[c] == 0 && candidate(c).flat; }

        /// By how much the sum falls when both cells, which have the same label, get another.
        double gain(const std::array<std::size_t, 2>& pair, int label)
        {
            const int own = cells_.labels[pair[0]];
            double gained = 0.0;
            for (const std::size_t c : pair) {
                const Cell& cell = candidate(c);
                gained += misfit(cell, own) - misfit(cell, label);
                for (std::size_t i = 0; i < 4; ++i) {
                    const TetId n = cells_.neighbours[c][i];
                    if (n >= 0 && (u(n) == pair[0] || u(n) == pair[1])) // the face between them
                        continue;
                    const int other = beyond(c, i);
                    gained += kAreaLength * cell.areas[i] * ((other != own ? 1.0 : 0.0) - (other != label ? 1.0 : 0.0));
                }
            }
            return gained;
        }

        Cell& candidate(std::size_t c)
        {
            if (candidate_[c] < 0)
                add(c);
            return candidates_[u(candidate_[c])];
        }

        Vec3 corner(std::size_t c, std::size_t i) const { return cells_.vertices[u(cells_.tets[c][i])]; }
        int beyond(std::size_t c, std::size_t i) const
        {
            const TetId n = cells_.neighbours[c][i];
            return n < 0 ? 0 : cells_.labels[u(n)];
        }

        bool near_interface(std::size_t c) const
        {
            for (std::size_t i = 0; i < 4; ++i)
                if (beyond(c, i) != cells_.labels[c])
                    return true;
            return false;
        }

        void add(std::size_t c)
        {
            Cell cell {};
            cell.number = c;
            const std::array<Vec3, 4> p { corner(c, 0), corner(c, 1), corner(c, 2), corner(c, 3) };
            cell.volume = tet_volume(p[0], p[1], p[2], p[3]);
            for (int i = 0; i < 4; ++i)
                cell.areas[u(i)] = triangle_area(face_corners(p, i));
            for (std::size_t s = 0; s < kCellSamples.size(); ++s) {
                Vec3 at = Vec3::Zero();
                for (std::size_t i = 0; i < 4; ++i)
                    at += kCellSamples[s][i] * p[i];
                cell.samples[s] = field_.at(at);
            }
            const auto angles = dihedral_angles_deg(p[0], p[1], p[2], p[3]);
            const double smallest = *std::min_element(angles.begin(), angles.end());
            cell.flat = smallest < kFlattestAdded;
            if (smallest < kFlattestFilled)
                cell.volume *= kFlatWeight;
            candidate_[c] = static_cast<TetId>(candidates_.size());
            candidates_.push_back(cell);
        }

        static double misfit(const Cell& cell, int label)
        {
            const auto misfits
                = std::count_if(cell.samples.begin(), cell.samples.end(), [&](int sample) { return sample != label; });
            return cell.volume * static_cast<double>(misfits) / static_cast<double>(kCellSamples.size());
        }

        double energy(const Cell& cell, int label) const
        {
            double sum = misfit(cell, label);
            for (std::size_t i = 0; i < 4; ++i)
                if (beyond(cell.number, i) != label)
                    sum += kAreaLength * cell.areas[i];
            return sum;
        }

        bool improve(const Cell& cell)
        {
            std::uint8_t& label = cells_.labels[cell.number];
            int best = label;
            double least = energy(cell, label) * (1.0 - 1e-9);
            for (std::size_t i = 0; i < 4; ++i) {
                const int other = beyond(cell.number, i);
                if (other == best || (label == 0 && cell.flat))
                    continue;
                if (const double e = energy(cell, other); e < least) {
                    least = e;
                    best = other;
                }
            }
            const bool changed = best != label;
            label = static_cast<std::uint8_t>(best);
            return changed;
        }

        LabelledCells& cells_;
        const LabelField& field_;
        std::vector<TetId>
            candidate_; ///< index in candidates_ of each cell; -1 while the cell has been on no interface
        std::vector<Cell> candidates_;
    };

} // namespace

void fit_labels(LabelledCells& cells, const LabelField& field) { Fit(cells, field).run(); }

} // namespace retractor::mesh
