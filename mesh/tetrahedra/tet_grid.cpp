#include "mesh/tetrahedra/tet_grid.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::mesh {

namespace {
    constexpr int kMostCellsPerAxis = 256; // bounds the memory for a mesh with a few far vertices
    constexpr std::array<std::int16_t, 6> kNotListed { 1, 0, 1, 0, 1, 0 };
} // namespace

TetGrid::TetGrid(const Eigen::AlignedBox3d& box, double cell)
    : origin_(box.min())
    , cell_(std::max(cell, box.sizes().maxCoeff() / kMostCellsPerAxis))
{
    RETRACTOR_ASSERT(!box.isEmpty() && cell > 0.0);
    for (int axis = 0; axis < 3; ++axis)
        size_[static_cast<std::size_t>(axis)] = std::max(1, static_cast<int>(std::ceil(box.sizes()[axis] / cell_)));
    cells_.resize(
        static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]));
}

TetGrid::Range TetGrid::range(const Eigen::AlignedBox3d& box) const
{
    Range r {};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const auto cell = [&](double x) {
            const double at = std::floor((x - origin_[axis]) / cell_);
            return static_cast<std::int16_t>(std::clamp(at, 0.0, static_cast<double>(size_[a] - 1)));
        };
        r[2 * a] = cell(box.min()[axis]);
        r[2 * a + 1] = cell(box.max()[axis]);
    }
    return r;
}

template <class Visit> void TetGrid::for_cells(const Range& r, Visit&& visit) const
{
    for (int k = r[4]; k <= r[5]; ++k)
        for (int j = r[2]; j <= r[3]; ++j)
            for (int i = r[0]; i <= r[1]; ++i)
                visit((static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(j))
                        * static_cast<std::size_t>(size_[0])
                    + static_cast<std::size_t>(i));
}

void TetGrid::insert(TetId t, const Eigen::AlignedBox3d& box)
{
    const auto id = static_cast<std::size_t>(t);
    if (listed_.size() <= id)
        listed_.resize(id + 1, kNotListed);
    const Range now = range(box);
    if (now == listed_[id])
        return;
    remove(t);
    listed_[id] = now;
    for_cells(now, [&](std::size_t cell) { cells_[cell].push_back(t); });
}

void TetGrid::remove(TetId t)
{
    RETRACTOR_ASSERT(t >= 0 && static_cast<std::size_t>(t) < listed_.size());
    Range& listed = listed_[static_cast<std::size_t>(t)];
    for_cells(listed, [&](std::size_t cell) {
        auto& tets = cells_[cell];
        RETRACTOR_ASSERT(std::find(tets.begin(), tets.end(), t) != tets.end());
        *std::find(tets.rbegin(), tets.rend(), t) = tets.back(); // cuts mostly remove elements that they have just made
        tets.pop_back();
    });
    listed = kNotListed;
}

void TetGrid::gather(const Eigen::AlignedBox3d& box, std::vector<TetId>& out) const
{
    for_cells(range(box), [&](std::size_t cell) { out.insert(out.end(), cells_[cell].begin(), cells_[cell].end()); });
}

std::size_t TetGrid::bytes() const
{
    std::size_t sum = listed_.capacity() * sizeof(Range) + cells_.capacity() * sizeof(cells_[0]);
    for (const auto& cell : cells_)
        sum += cell.capacity() * sizeof(TetId);
    return sum;
}

} // namespace retractor::mesh
