// The side that a blade gives to a point is that of CGAL's exact orientation with respect to the triangle nearest to
// the point, for every point farther from it than the tolerance within which a point counts as on the blade.

#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/stroke/cut_marks.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

namespace retractor::mesh {
namespace blade_predicates_test {

    using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;

    constexpr int kPoints = 20000; // per blade
    /// Distances (in blade sizes) at which points are tried: just beyond the tolerance first.
    constexpr std::array<double, 6> kOffsets { 2e-10, 1e-9, 1e-7, 1e-4, 1e-2, 0.3 };

    Exact::Point_3 exact(const Vec3& p) { return { p.x(), p.y(), p.z() }; }

    /// +1 on the side of the triangle's normal.
    int exact_side(const std::array<Vec3, 3>& t, const Vec3& p)
    {
        return static_cast<int>(CGAL::orientation(exact(t[0]), exact(t[1]), exact(t[2]), exact(p)));
    }

    struct Shape {
        const char* name;
        Blade blade;
    };

    std::vector<Shape> shapes()
    {
        std::vector<Shape> all {
            { "straight",
                { .line = { { 3, 5, 7 }, { 43, 25, 9 } }, .directions = { { 0.2, 0.3, -1 } }, .depth_mm = 12 } },
            { "kinked",
                { .line = { { 0, 0, 0 }, { 11, 3, 0.3 }, { 19, 12, -0.2 }, { 33, 13, 0.1 }, { 40, 2, 0 } },
                    .directions = { { 0.1, -0.2, -1 } },
                    .depth_mm = 9 } },
            { "twisted",
                { .line = { { 0, 0, 0 }, { 9, 1, 0 }, { 18, 3, 0 }, { 27, 3, 0 } },
                    .directions = { { 0.3, 0.3, -1 }, { 0.1, 0.2, -1 }, { -0.1, -0.1, -1 }, { -0.3, -0.2, -1 } },
                    .depth_mm = 11 } },
        };
        Blade arc { .line = {}, .directions = {}, .depth_mm = 14 };
        for (int i = 0; i <= 16; ++i) {
            const double a = std::numbers::pi * i / 24.0;
            arc.line.emplace_back(60.0 * std::cos(a), 60.0 * std::sin(a), 200.0);
            arc.directions.emplace_back(-std::cos(a), -std::sin(a), 0.2);
        }
        all.push_back({ "arc", arc });
        return all;
    }

    class BladePredicates : public testing::TestWithParam<std::size_t> { };

    TEST_P(BladePredicates, TheSideIsThatOfExactOrientation)
    {
        const Shape shape = shapes()[GetParam()];
        const SweptBlade blade(shape.blade);
        const TriMesh& surface = blade.surface();
        const double size = std::max(blade.length(), blade.depth());
        std::mt19937_64 random(17);
        const auto uniform
            = [&](double low, double high) { return low + (high - low) * std::generate_canonical<double, 53>(random); };
        std::size_t compared = 0, flat = 0, creased = 0;
        for (int i = 0; i < kPoints; ++i) {
            // A point of a triangle, of an edge (creases, front and ends among them) or a vertex; pushed off it.
            const auto& t = surface.triangles[random() % surface.triangles.size()];
            std::array<double, 3> w { uniform(0, 1), uniform(0, 1), uniform(0, 1) };
            const auto kind = random() % 4;
            if (kind >= 1)
                w[random() % 3] = 0.0;
            if (kind == 2)
                w = { 1.0, 0.0, 0.0 };
            const double sum = std::max(w[0] + w[1] + w[2], 1e-3);
            std::array<Vec3, 3> corners;
            Vec3 p = Vec3::Zero();
            for (std::size_t k = 0; k < 3; ++k) {
                corners[k] = surface.vertices.row(t[k]);
                p += w[k] / sum * corners[k];
            }
            Vec3 away(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
            const double offset = kOffsets[random() % kOffsets.size()] * size;
            p += offset * away.normalized();
            const BladeCoordinates c = blade.coordinates(p);
            const int side = sign(c.side, kOnBlade * size);
            if (side == 0)
                continue; // on the blade by the tolerance
            const auto near = blade.nearest_triangle(p);
            const int truth = exact_side(near, p);
            ASSERT_EQ(side, truth) << shape.name << " point " << i << ": side " << c.side << " mm at along " << c.along
                                   << ", depth " << c.depth;
            ++compared;
            (kind == 0 ? flat : creased) += 1;
        }
        EXPECT_GE(compared, static_cast<std::size_t>(kPoints) / 2);
        EXPECT_GE(flat, 1000u);
        EXPECT_GE(creased, 1000u);
    }

    INSTANTIATE_TEST_SUITE_P(Shapes, BladePredicates, testing::Range(std::size_t { 0 }, std::size_t { 4 }),
        [](const auto& each) { return std::string(shapes()[each.param].name); });

} // namespace blade_predicates_test
} // namespace retractor::mesh
