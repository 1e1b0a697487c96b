#include "haptics/spheres/sphere_filling.h"

#include "haptics/spheres/surface_locator.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

namespace retractor::haptics {

namespace {

    using Site = std::array<int, 3>;

    /// Lattice sites with even i + j + k, `edge` apart along the axes. Nearest sites are sqrt 2 times `edge` apart.
    std::vector<Site> sites_inside(const SurfaceLocator& surface, double radius)
    {
        const double edge = radius * std::numbers::sqrt2;
        const Vec3 middle = 0.5 * (surface.low() + surface.high());
        const Vec3 half = 0.5 * (surface.high() - surface.low());
        if (half.prod() * 8.0 / (2.0 * edge * edge * edge) > 20.0 * static_cast<double>(kMostSpheres))
            throw InputError("spheres of radius " + std::to_string(radius) + " mm are too small for this surface");
        const auto reach = [&](Eigen::Index axis) { return static_cast<int>(half(axis) / edge); };
        std::vector<Site> sites;
        for (int k = -reach(2); k <= reach(2); ++k)
            for (int j = -reach(1); j <= reach(1); ++j)
                for (int i = -reach(0); i <= reach(0); ++i) {
                    if (((i + j + k) & 1) != 0)
                        continue;
                    const Vec3 centre = middle + edge * Vec3(i, j, k);
                    if (surface.inside(centre) && !surface.is_near(centre, radius))
                        sites.push_back({ i, j, k });
                }
        return sites;
    }

    SphereFilling filling_of(const SurfaceLocator& surface, const std::vector<Site>& sites, double radius)
    {
        RETRACTOR_ASSERT(!sites.empty() && radius > 0.0);
        SphereFilling filling;
        filling.radius = radius;
        filling.centres.resize(static_cast<Eigen::Index>(sites.size()), 3);
        std::map<Site, std::int32_t> number;
        const Vec3 middle = 0.5 * (surface.low() + surface.high());
        for (std::size_t s = 0; s < sites.size(); ++s) {
            number.emplace(sites[s], static_cast<std::int32_t>(s));
            filling.centres.row(static_cast<Eigen::Index>(s))
                = (middle + radius * std::numbers::sqrt2 * Vec3(sites[s][0], sites[s][1], sites[s][2])).transpose();
        }
        filling.first.push_back(0);
        for (const Site& site : sites) {
            const auto begin = filling.neighbours.size();
            for (const auto& [x, y] : { std::pair { 1, 1 }, { 1, -1 }, { -1, 1 }, { -1, -1 } })
                for (const Site& step : { Site { x, y, 0 }, Site { x, 0, y }, Site { 0, x, y } })
                    if (const auto at = number.find({ site[0] + step[0], site[1] + step[1], site[2] + step[2] });
                        at != number.end())
                        filling.neighbours.push_back(at->second);
            std::sort(filling.neighbours.begin() + static_cast<std::ptrdiff_t>(begin), filling.neighbours.end());
            filling.first.push_back(static_cast<std::int32_t>(filling.neighbours.size()));
        }
        constexpr double kFarthest = 2.5; // in radii; gaps are smaller under a nearly flat surface
        for (std::size_t i = 0; i < sites.size(); ++i)
            filling.reach.push_back(filling.of(i).size() == 12
                    ? radius
                    : surface.distance_within(
                        filling.centres.row(static_cast<Eigen::Index>(i)).transpose(), kFarthest * radius));
        RETRACTOR_ASSERT(filling.first.size() == sites.size() + 1 && filling.reach.size() == sites.size());
        return filling;
    }

} // namespace

SphereFilling fill_with_spheres(const TriMesh& surface, double radius)
{
    if (!(radius > 0.0) || !std::isfinite(radius))
        throw InputError("the spheres' radius must be positive, got " + std::to_string(radius));
    const SurfaceLocator locator(surface);
    const std::vector<Site> sites = sites_inside(locator, radius);
    if (sites.empty())
        throw InputError("no sphere of radius " + std::to_string(radius) + " mm fits into the surface");
    if (sites.size() > kMostSpheres)
        throw InputError(
            "more than a million spheres of radius " + std::to_string(radius) + " mm fit into the surface");
    return filling_of(locator, sites, radius);
}

SphereFilling fill_with_count(const TriMesh& surface, std::size_t wanted, double tolerance)
{
    if (wanted < 1 || wanted > kMostSpheres)
        throw InputError("an organ is filled with 1 to a million spheres, got " + std::to_string(wanted));
    const SurfaceLocator locator(surface);
    const double volume = enclosed_volume(surface.vertices, surface.triangles);
    if (!(volume > 0.0))
        throw InputError("the surface encloses no volume, or is oriented inwards");
    const auto aim = static_cast<double>(wanted);
    std::vector<Site> best;
    double best_radius = 0.0;
    const auto attempt = [&](double radius) {
        std::vector<Site> sites = sites_inside(locator, radius);
        const auto count = static_cast<double>(sites.size());
        if (best.empty() || std::abs(count - aim) < std::abs(static_cast<double>(best.size()) - aim)) {
            best = std::move(sites);
            best_radius = radius;
        }
        return count;
    };
    // A sphere of the lattice takes the volume 4 sqrt 2 r^3. The rim, where no sphere fits, reduces the count, so the
    // bisection starts from this radius downwards.
    double high = std::cbrt(volume / (aim * 4.0 * std::numbers::sqrt2)), low = 0.3 * high;
    constexpr int kHalvings = 14;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        (attempt(middle) > aim ? low : high) = middle;
    }
    // The count is no smooth function of the radius, so nearby radii are tried as well.
    const auto off = [&] { return std::abs(static_cast<double>(best.size()) - aim) / aim; };
    const double around = 0.5 * (low + high);
    for (int i = 1; i <= 60 && off() > 0.25 * tolerance; ++i)
        attempt(around * (1.0 + (i % 2 == 0 ? 1.0 : -1.0) * 5e-4 * i));
    if (best.empty() || off() > tolerance)
        throw InputError("no radius gives " + std::to_string(wanted) + " spheres; " + std::to_string(best_radius)
            + " mm gives " + std::to_string(best.size()));
    return filling_of(locator, best, best_radius);
}

} // namespace retractor::haptics
