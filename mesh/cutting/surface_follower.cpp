#include "mesh/cutting/surface_follower.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace retractor::mesh {

namespace {
    constexpr std::int64_t kSurface = -1; ///< no element on the other side
    constexpr std::int64_t kOpen = -2; ///< the neighbour is gone and has no successor yet

    [[noreturn]] void refuse(TetId t)
    {
        throw InputError("the delta does not fit the surface it should change", "element " + std::to_string(t));
    }
} // namespace

std::size_t SurfaceFollower::KeyHash::operator()(const Key& key) const
{
    std::uint64_t hash = 0;
    for (const VertexId v : key) {
        hash = (hash ^ static_cast<std::uint32_t>(v)) * 0x9e3779b97f4a7c15ULL; // 2^64 / golden ratio
        hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
}

SurfaceFollower::SurfaceFollower(const TetMesh& mesh)
    : positions_(mesh.vertex_count())
    , nodes_(mesh.tet_count())
    , labels_(mesh.labels)
    , mates_(4 * mesh.tet_count(), kSurface)
{
    RETRACTOR_ASSERT(mesh.nodes_per_tet == 4);
    for (std::size_t v = 0; v < positions_.size(); ++v)
        positions_[v] = mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose();
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        std::copy_n(mesh.tet(t).begin(), 4, nodes_[static_cast<std::size_t>(t)].begin());
    pair_all();
    place_.reserve(2 * static_cast<std::size_t>(std::count(mates_.begin(), mates_.end(), kSurface)));
    for (std::size_t half = 0; half < mates_.size(); ++half)
        if (mates_[half] == kSurface)
            show(static_cast<Half>(half));
}

SurfaceFollower::Key SurfaceFollower::key(Half half) const
{
    Key key = face_corners(nodes_[static_cast<std::size_t>(half / 4)], static_cast<int>(half % 4));
    std::sort(key.begin(), key.end());
    return key;
}

/// Sorts faces into buckets by their least vertex; buckets are small for every mesh.
void SurfaceFollower::pair_all()
{
    std::vector<std::size_t> start(positions_.size() + 1, 0);
    for (std::size_t half = 0; half < mates_.size(); ++half)
        ++start[static_cast<std::size_t>(key(static_cast<Half>(half))[0]) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<std::pair<Key, Half>> sorted(mates_.size());
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    for (std::size_t half = 0; half < mates_.size(); ++half) {
        const Key k = key(static_cast<Half>(half));
        sorted[next[static_cast<std::size_t>(k[0])]++] = { k, static_cast<Half>(half) };
    }
    for (std::size_t v = 0; v < positions_.size(); ++v)
        std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(start[v]),
            sorted.begin() + static_cast<std::ptrdiff_t>(start[v + 1]));
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i) {
        if (sorted[i].first != sorted[i + 1].first)
            continue;
        if (i + 2 < sorted.size() && sorted[i + 2].first == sorted[i].first)
            throw InputError(
                "a face belongs to more than two elements", "element " + std::to_string(sorted[i].second / 4));
        mate(sorted[i].second) = sorted[i + 1].second;
        mate(sorted[i + 1].second) = sorted[i].second;
    }
}

void SurfaceFollower::show(Half half)
{
    RETRACTOR_ASSERT(half >= 0 && static_cast<std::size_t>(half) < mates_.size());
    mate(half) = kSurface;
    const auto t = static_cast<std::size_t>(half / 4);
    const auto corner = static_cast<int>(half % 4);
    const SurfaceFace face { { static_cast<TetId>(half / 4), corner }, face_corners(nodes_[t], corner), labels_[t] };
    if (!place_.try_emplace(key(half), faces_.size()).second)
        refuse(face.face.tet);
    changed_.push_back(faces_.size());
    faces_.push_back(face);
}

void SurfaceFollower::hide(const Key& gone)
{
    const auto it = place_.find(gone);
    if (it == place_.end())
        refuse(-1);
    const std::size_t place = it->second;
    RETRACTOR_ASSERT(place < faces_.size());
    place_.erase(it);
    if (place + 1 < faces_.size()) { // the last face takes the free place
        faces_[place] = faces_.back();
        place_.at(key(4 * Half { faces_[place].face.tet } + faces_[place].face.corner)) = place;
        changed_.push_back(place);
    }
    faces_.pop_back();
}

void SurfaceFollower::take(const MeshDelta::Tet& tet)
{
    const auto t = static_cast<std::size_t>(tet.id);
    if (tet.id < 0 || t >= nodes_.size() || nodes_[t] != tet.nodes)
        refuse(tet.id);
    for (Half half = 4 * Half { tet.id }; half < 4 * Half { tet.id } + 4; ++half) {
        const Key k = key(half);
        const Half other = mate(half);
        if (other == kSurface) {
            hide(k);
        } else if (other == kOpen) {
            open_.erase(k);
        } else {
            mate(other) = kOpen;
            open_[k] = other;
        }
    }
    // The nodes stay until all elements are taken, because hide() needs the keys of other faces.
}

void SurfaceFollower::put(const MeshDelta::Tet& tet)
{
    const auto t = static_cast<std::size_t>(tet.id);
    if (tet.id < 0)
        refuse(tet.id);
    if (t >= nodes_.size()) {
        nodes_.resize(t + 1, { -1, -1, -1, -1 });
        labels_.resize(t + 1, 0);
        mates_.resize(4 * (t + 1), kOpen);
    }
    if (nodes_[t][0] >= 0)
        refuse(tet.id);
    for (const VertexId v : tet.nodes)
        if (v < 0 || static_cast<std::size_t>(v) >= positions_.size())
            refuse(tet.id);
    nodes_[t] = tet.nodes;
    labels_[t] = tet.label;
    for (Half half = 4 * Half { tet.id }; half < 4 * Half { tet.id } + 4; ++half) {
        const Key k = key(half);
        Half other = kOpen;
        if (const auto it = open_.find(k); it != open_.end()) {
            other = it->second;
            open_.erase(it);
        } else if (const auto at = place_.find(k);
                   at != place_.end()) { // undo puts a removed piece back on a bare face
            const TetFace& face = faces_[at->second].face;
            other = 4 * Half { face.tet } + face.corner;
            hide(k);
        }
        mate(half) = other;
        if (other == kOpen)
            open_[k] = half;
        else
            mate(other) = half;
    }
}

void SurfaceFollower::follow(const MeshDelta& delta)
{
    changed_.clear();
    open_.clear();
    for (const MeshDelta::VertexBorn& born : delta.vertices_born) {
        if (static_cast<std::size_t>(born.id) >= positions_.size())
            positions_.resize(static_cast<std::size_t>(born.id) + 1, Vec3::Zero());
        positions_[static_cast<std::size_t>(born.id)] = born.position;
    }
    for (const MeshDelta::VertexMoved& moved : delta.vertices_moved)
        positions_[static_cast<std::size_t>(moved.id)] = moved.to;
    for (const MeshDelta::Tet& tet : delta.tets_gone)
        take(tet);
    for (const MeshDelta::Tet& tet : delta.tets_gone)
        nodes_[static_cast<std::size_t>(tet.id)] = { -1, -1, -1, -1 };
    for (const MeshDelta::Tet& tet : delta.tets_born)
        put(tet);
    std::vector<Half> bare;
    bare.reserve(open_.size());
    for (const auto& [k, half] : open_)
        bare.push_back(half);
    std::sort(bare.begin(), bare.end()); // removes the order of the hash table
    for (const Half half : bare)
        show(half);
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    while (!changed_.empty() && changed_.back() >= faces_.size())
        changed_.pop_back();
}

} // namespace retractor::mesh
