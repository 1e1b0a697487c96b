#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/stroke/cut_patterns.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace retractor::mesh {
namespace cut_patterns_test {

    constexpr double kRoundOff = 1e-12; // of a sum of some hundred volumes
    constexpr double kOnBlade = 1e-9; // mm, with blades of some mm

    using FaceKey = std::array<VertexId, 3>;

    TetMesh one_tet()
    {
        TetMesh mesh;
        mesh.vertices.resize(4, 3);
        mesh.vertices << 0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.2, 1.1, 0.1, 0.3, 0.2, 0.9;
        mesh.nodes = { 0, 1, 2, 3 };
        mesh.labels = { 7 };
        return mesh;
    }

    Vec3 at(const TetMesh& mesh, VertexId v) { return mesh.vertices.row(v).transpose(); }

    /// A flat blade, larger than an element of unit size, through three points.
    Blade blade_through(const Vec3& a, const Vec3& b, const Vec3& c)
    {
        const Vec3 u = (b - a).normalized(), n = u.cross(c - a).normalized(), down = n.cross(u);
        const Vec3 middle = (a + b + c) / 3.0;
        return { .line = { middle - 4.0 * u - 4.0 * down, middle + 4.0 * u - 4.0 * down },
            .directions = { down },
            .depth_mm = 8.0 };
    }

    Vec3 between(const TetMesh& mesh, VertexId a, VertexId b, double t)
    {
        return (1.0 - t) * at(mesh, a) + t * at(mesh, b);
    }

    /// Cuts off corner 0.
    Blade triangle_section(const TetMesh& mesh)
    {
        return blade_through(between(mesh, 0, 1, 0.4), between(mesh, 0, 2, 0.45), between(mesh, 0, 3, 0.35));
    }

    /// Parts corners 0 and 1 from 2 and 3.
    Blade quadrilateral_section(const TetMesh& mesh)
    {
        return blade_through(between(mesh, 0, 2, 0.4), between(mesh, 0, 3, 0.45), between(mesh, 1, 2, 0.55));
    }

    double volume(const TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += tet_volume(mesh, t);
        return sum;
    }

    /// Elements of the one element after a cut; lips checked on the way.
    std::size_t parts(const Blade& blade, Subdivision subdivision, std::size_t lip_faces)
    {
        const TetMesh mesh = one_tet();
        const CutMesh done = cut(mesh, blade, { .subdivision = subdivision });
        EXPECT_EQ(done.status, CutStatus::done) << done.message;
        EXPECT_EQ(done.report.tets_crossed, 1u);
        for (TetId t = 0; t < static_cast<TetId>(done.mesh.tet_count()); ++t)
            EXPECT_GT(tet_volume(done.mesh, t), 0.0) << "element " << t;
        EXPECT_NEAR(volume(done.mesh), volume(mesh), kRoundOff);
        EXPECT_EQ(connected_pieces(done.mesh).size(), done.mesh.tet_count());
        const std::vector<int> pieces = connected_pieces(done.mesh);
        EXPECT_EQ(*std::max_element(pieces.begin(), pieces.end()), 1) << "two pieces";
        const SweptBlade swept(blade);
        std::map<int, std::vector<std::array<std::array<double, 3>, 3>>> sides;
        for (const LipFace& lip : done.lips) {
            auto& corners = sides[lip.side].emplace_back();
            std::size_t i = 0;
            for (const VertexId v : face_vertices(done.mesh, lip.face)) {
                EXPECT_NEAR(swept.coordinates(at(done.mesh, v)).side, 0.0, kOnBlade);
                const Vec3 p = at(done.mesh, v);
                corners[i++] = { p.x(), p.y(), p.z() };
            }
            std::sort(corners.begin(), corners.end());
        }
        for (auto& [side, faces] : sides)
            std::sort(faces.begin(), faces.end());
        EXPECT_EQ(sides[-1].size(), lip_faces);
        EXPECT_EQ(sides[-1], sides[1]) << "the lips mirror each other";
        EXPECT_TRUE(std::all_of(done.origin.begin(), done.origin.end(), [](TetId t) { return t == 0; }));
        EXPECT_TRUE(std::all_of(done.mesh.labels.begin(), done.mesh.labels.end(), [](Label l) { return l == 7; }));
        return done.mesh.tet_count();
    }

    TEST(CutPatterns, CountsOfATriangleSection)
    {
        const Blade blade = triangle_section(one_tet());
        EXPECT_EQ(parts(blade, Subdivision::general, 4), 17u);
        EXPECT_EQ(parts(blade, Subdivision::intermediate_5, 1), 8u);
        EXPECT_EQ(parts(blade, Subdivision::intermediate_11, 1), 4u);
    }

    TEST(CutPatterns, CountsOfAQuadrilateralSection)
    {
        const Blade blade = quadrilateral_section(one_tet());
        EXPECT_EQ(parts(blade, Subdivision::general, 6), 18u);
        EXPECT_EQ(parts(blade, Subdivision::intermediate_5, 2), 8u);
        EXPECT_EQ(parts(blade, Subdivision::intermediate_11, 2), 6u);
    }

    TEST(CutPatterns, SectionsThroughCorners)
    {
        const TetMesh mesh = one_tet();
        const Blade one = blade_through(at(mesh, 0), between(mesh, 1, 2, 0.5), between(mesh, 1, 3, 0.4));
        EXPECT_EQ(parts(one, Subdivision::general, 4), 17u);
        EXPECT_EQ(parts(one, Subdivision::intermediate_5, 1), 3u) << "no red element has such a section: bisected";
        const Blade two = blade_through(at(mesh, 0), at(mesh, 1), between(mesh, 2, 3, 0.5));
        for (const Subdivision subdivision :
            { Subdivision::general, Subdivision::intermediate_5, Subdivision::intermediate_11 })
            EXPECT_EQ(parts(two, subdivision, 1), 2u);
    }

    TEST(CutPatterns, NothingMovesAndNoVolumeIsLost)
    {
        const TetMesh box = kuhn_box(6, 5, 4, 2.0);
        const Blade blade { .line = { { 1.1, 4.3, 8.0 }, { 6.2, 5.1, 8.0 }, { 9.9, 4.9, 8.0 } },
            .directions = { { 0.1, 0.15, -1.0 } },
            .depth_mm = 5.2 };
        for (const Subdivision subdivision :
            { Subdivision::general, Subdivision::intermediate_5, Subdivision::intermediate_11 }) {
            CutSession session(box);
            const CutResult result = session.cut(blade, { .subdivision = subdivision });
            ASSERT_EQ(result.status, CutStatus::done) << result.message;
            EXPECT_EQ(result.report.vertices_moved, 0u);
            EXPECT_EQ(result.report.tets_crossed, crossed_elements(box, SweptBlade(blade)).size());
            const TetMesh after = session.compact_mesh();
            check_mesh(after);
            EXPECT_NEAR(volume(after), volume(box), kRoundOff * volume(box));
            double before = 0.0, lips = 0.0;
            for (const TetFace& face : boundary_faces(box)) {
                const auto v = face_vertices(box, face);
                before += 0.5 * (at(box, v[1]) - at(box, v[0])).cross(at(box, v[2]) - at(box, v[0])).norm();
            }
            for (const TetFace& face : boundary_faces(after)) {
                const auto v = face_vertices(after, face);
                lips += 0.5 * (at(after, v[1]) - at(after, v[0])).cross(at(after, v[2]) - at(after, v[0])).norm();
            }
            EXPECT_NEAR(lips - before, 2.0 * result.report.lip_area_mm2, kRoundOff * before)
                << "T-junctions would show as surface";
        }
    }

    TEST(CutPatterns, IncreaseOfABoxLiesInTheSourcesOrder)
    {
        const TetMesh box = kuhn_box(10, 10, 5, 4.0);
        const Blade blade { .line = { { 6.0, 20.9, 20.0 }, { 34.0, 23.1, 20.0 } },
            .directions = { { 0.02, 0.17, -1.0 } },
            .depth_mm = 12.0 };
        const auto increase = [&](Subdivision subdivision) {
            CutSession session(box);
            const CutResult result = session.cut(blade, { .subdivision = subdivision });
            EXPECT_EQ(result.status, CutStatus::done) << result.message;
            return result.report.mean_increase();
        };
        const double general = increase(Subdivision::general), five = increase(Subdivision::intermediate_5),
                     eleven = increase(Subdivision::intermediate_11), adaptive = increase(Subdivision::adaptive);
        EXPECT_GT(general, 16.0) << "1:17, and neighbours";
        EXPECT_GT(five, 7.0) << "1:8, and neighbours";
        EXPECT_LT(five, general);
        EXPECT_LT(eleven, five);
        EXPECT_LT(adaptive, eleven);
    }

    TEST(CutPatterns, UndoBringsEveryBitBack)
    {
        const TetMesh box = kuhn_box(5, 5, 3, 3.0);
        for (const Subdivision subdivision : { Subdivision::general, Subdivision::intermediate_5 }) {
            CutSession session(box);
            const Blade blade {
                .line = { { 2.0, 7.3, 9.0 }, { 13.1, 8.2, 9.0 } }, .directions = { { 0.1, 0.1, -1.0 } }, .depth_mm = 5.0
            };
            ASSERT_EQ(session.cut(blade, { .subdivision = subdivision }).status, CutStatus::done);
            const TetMesh cut_once = session.compact_mesh();
            session.undo();
            const TetMesh back = session.compact_mesh();
            EXPECT_EQ(back.nodes, box.nodes);
            EXPECT_TRUE((back.vertices.array() == box.vertices.array()).all());
            session.redo();
            EXPECT_EQ(session.compact_mesh().nodes, cut_once.nodes);
            EXPECT_TRUE((session.compact_mesh().vertices.array() == cut_once.vertices.array()).all());
        }
    }

    TEST(CutPatterns, LipsOfAnEarlierCutStayLips)
    {
        const TetMesh box = kuhn_box(5, 5, 3, 3.0);
        for (const Subdivision subdivision : { Subdivision::general, Subdivision::intermediate_5 }) {
            CutSession session(box);
            const auto area = [&](int number) {
                SlotMap map;
                const TetMesh mesh = session.compact_mesh(&map);
                double sum = 0.0;
                for (LipFace lip : session.lips())
                    if (lip.cut == number) {
                        lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
                        const auto v = face_vertices(mesh, lip.face);
                        sum += 0.5 * (at(mesh, v[1]) - at(mesh, v[0])).cross(at(mesh, v[2]) - at(mesh, v[0])).norm();
                    }
                return sum;
            };
            const auto stroke = [&](const Vec3& from, const Vec3& to) {
                const CutResult result
                    = session.cut({ .line = { from, to }, .directions = { { 0.1, 0.12, -1.0 } }, .depth_mm = 4.1 },
                        { .subdivision = subdivision });
                ASSERT_EQ(result.status, CutStatus::done) << result.message;
            };
            stroke({ 2.0, 7.3, 9.0 }, { 13.1, 8.2, 9.0 });
            const double first = area(0);
            stroke({ 7.1, 2.2, 9.0 }, { 8.3, 13.1, 9.0 });
            EXPECT_NEAR(area(0), first, kRoundOff * first);
        }
    }

} // namespace cut_patterns_test
} // namespace retractor::mesh
