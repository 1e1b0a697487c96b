#include "haptics/surroundings/distance_grid.h"

#include "mesh/base/error.h"
#include "mesh/surface/proximity.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::haptics {

namespace {

    /// A triangle of one of the surfaces.
    struct Face {
        std::array<Vec3, 3> corners;
        std::int16_t surface = 0;

        double distance(const Vec3& p) const
        {
            return mesh::closest_on_triangle(p, corners[0], corners[1], corners[2]).distance;
        }
    };

    std::vector<Face> faces_of(
        const std::vector<mesh::NamedSurface>& surfaces, const Eigen::AlignedBox3d& box, double margin)
    {
        if (surfaces.size() > static_cast<std::size_t>(std::numeric_limits<std::int16_t>::max()))
            throw InputError("there are too many surfaces round the finger");
        std::vector<Face> faces;
        for (std::size_t s = 0; s < surfaces.size(); ++s) {
            const TriMesh& mesh = surfaces[s].surface;
            for (const auto& triangle : mesh.triangles) {
                Face face { .corners = {}, .surface = static_cast<std::int16_t>(s) };
                for (std::size_t k = 0; k < 3; ++k) {
                    if (triangle[k] < 0 || triangle[k] >= mesh.vertices.rows())
                        throw InputError("a triangle has a vertex that does not exist", surfaces[s].name);
                    face.corners[k] = mesh.vertices.row(triangle[k]).transpose();
                }
                const Vec3 low = face.corners[0].cwiseMin(face.corners[1]).cwiseMin(face.corners[2]),
                           high = face.corners[0].cwiseMax(face.corners[1]).cwiseMax(face.corners[2]);
                if (low.allFinite() && high.allFinite() && ((high - box.min()).array() > -margin).all()
                    && ((box.max() - low).array() > -margin).all())
                    faces.push_back(face);
            }
        }
        return faces;
    }

} // namespace

DistanceGrid::DistanceGrid(const std::vector<mesh::NamedSurface>& surfaces, const Eigen::AlignedBox3d& box,
    double step_mm, double farthest_mm, const Job& job)
    : origin_(box.min())
    , step_(step_mm)
    , farthest_(farthest_mm)
{
    if (!(step_mm > 0.0) || !(farthest_mm > 0.0) || !((box.max() - box.min()).array() > 0.0).all()
        || !box.max().allFinite() || !box.min().allFinite())
        throw InputError("box, step and largest distance of the surroundings must be positive");
    for (const mesh::NamedSurface& surface : surfaces)
        names_.push_back(surface.name);
    std::size_t count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        const double extent = box.max()[static_cast<Eigen::Index>(a)] - box.min()[static_cast<Eigen::Index>(a)];
        size_[a] = static_cast<int>(std::ceil(extent / step_mm)) + 1;
        count *= static_cast<std::size_t>(size_[a]);
    }
    distance_.assign(count, static_cast<float>(farthest_));
    const std::vector<Face> faces = faces_of(surfaces, box, farthest_);
    constexpr std::int32_t kNoFace = -1;
    std::vector<std::int32_t> face_of(count, kNoFace);
    const auto place = [&](int x, int y, int z) { return Vec3(origin_ + step_ * Vec3(x, y, z)); };
    const auto take = [&](std::size_t at, const Vec3& p, std::int32_t face) {
        const auto distance = static_cast<float>(faces[static_cast<std::size_t>(face)].distance(p));
        if (distance < distance_[at]) {
            distance_[at] = distance;
            face_of[at] = face;
        }
    };
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::array<int, 3> first {}, last {};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            double low = faces[f].corners[0][axis], high = low;
            for (const Vec3& corner : faces[f].corners) {
                low = std::min(low, corner[axis]);
                high = std::max(high, corner[axis]);
            }
            first[a] = std::max(static_cast<int>(std::floor((low - origin_[axis]) / step_)) - 1, 0);
            last[a] = std::min(static_cast<int>(std::ceil((high - origin_[axis]) / step_)) + 1, size_[a] - 1);
        }
        for (int z = first[2]; z <= last[2]; ++z)
            for (int y = first[1]; y <= last[1]; ++y)
                for (int x = first[0]; x <= last[0]; ++x)
                    take(index(x, y, z), place(x, y, z), static_cast<std::int32_t>(f));
    }
    constexpr int kSweeps = 8;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        if (job.cancelled())
            throw SolverError("cancelled");
        job.report("surroundings of the finger", static_cast<double>(sweep) / kSweeps);
        std::array<int, 3> step {};
        for (std::size_t a = 0; a < 3; ++a)
            step[a] = (sweep >> a & 1) != 0 ? -1 : 1;
        const auto begin = [&](std::size_t a) { return step[a] > 0 ? 0 : size_[a] - 1; };
        const auto goes_on = [&](std::size_t a, int i) { return i >= 0 && i < size_[a]; };
        for (int z = begin(2); goes_on(2, z); z += step[2])
            for (int y = begin(1); goes_on(1, y); y += step[1])
                for (int x = begin(0); goes_on(0, x); x += step[0]) {
                    const std::size_t at = index(x, y, z);
                    const std::array<std::array<int, 3>, 3> before { { { x - step[0], y, z }, { x, y - step[1], z },
                        { x, y, z - step[2] } } };
                    for (std::size_t a = 0; a < 3; ++a) {
                        if (!goes_on(a, before[a][a]))
                            continue;
                        const std::int32_t face = face_of[index(before[a][0], before[a][1], before[a][2])];
                        if (face != kNoFace && face != face_of[at])
                            take(at, place(x, y, z), face);
                    }
                }
    }
    surface_.resize(count);
    std::ranges::transform(face_of, surface_.begin(), [&](std::int32_t face) {
        return face == kNoFace ? static_cast<std::int16_t>(kNone) : faces[static_cast<std::size_t>(face)].surface;
    });
}

double DistanceGrid::distance(const Vec3& at) const noexcept
{
    const Vec3 in_steps = (at - origin_) / step_;
    std::array<int, 3> low {};
    Vec3 share;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        if (!(in_steps[axis] >= 0.0) || in_steps[axis] > static_cast<double>(size_[a] - 1))
            return farthest_;
        low[a] = std::min(static_cast<int>(in_steps[axis]), size_[a] - 2);
        share[axis] = in_steps[axis] - low[a];
    }
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2 & 1;
        sum += (dx != 0 ? share.x() : 1.0 - share.x()) * (dy != 0 ? share.y() : 1.0 - share.y())
            * (dz != 0 ? share.z() : 1.0 - share.z()) * distance_[index(low[0] + dx, low[1] + dy, low[2] + dz)];
    }
    return sum;
}

Eigen::AlignedBox3d DistanceGrid::box() const noexcept
{
    return { origin_, origin_ + step_ * Vec3(size_[0] - 1, size_[1] - 1, size_[2] - 1) };
}

bool DistanceGrid::contains(const Vec3& at) const noexcept
{
    const Vec3 in_steps = (at - origin_) / step_;
    for (std::size_t a = 0; a < 3; ++a)
        if (const double x = in_steps[static_cast<Eigen::Index>(a)];
            !(x >= 0.0) || x > static_cast<double>(size_[a] - 1))
            return false;
    return true;
}

Vec3 DistanceGrid::away(const Vec3& at) const noexcept
{
    Vec3 slope;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const Vec3 step = step_ * Vec3::Unit(axis);
        slope[axis] = distance(at + step) - distance(at - step);
    }
    const double length = slope.norm();
    return length > 0.0 ? Vec3(slope / length) : Vec3(Vec3::Zero());
}

int DistanceGrid::nearest(const Vec3& at) const noexcept
{
    std::array<int, 3> i {};
    for (std::size_t a = 0; a < 3; ++a) {
        const double in_steps
            = std::round((at[static_cast<Eigen::Index>(a)] - origin_[static_cast<Eigen::Index>(a)]) / step_);
        if (!(in_steps >= 0.0) || in_steps > static_cast<double>(size_[a] - 1))
            return kNone;
        i[a] = static_cast<int>(in_steps);
    }
    return surface_[index(i[0], i[1], i[2])];
}

} // namespace retractor::haptics
