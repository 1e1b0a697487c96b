#include "mesh/cutting/cut_session.h"

#include "mesh/base/error.h"
#include "mesh/cutting/stroke/cut_retry.h"
#include "tests/support/cutting/pinched_vertices.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <string>

namespace retractor::mesh {
namespace cut_session_test {

    constexpr double kOnBlade = 1e-9; // of the blade's size: the guarantee of the header
    constexpr double kRoundOff = 1e-12; // of a sum of some thousand volumes
    constexpr double kSnappedBorder = 0.1; // of the local edge: what depth and ends may be off where vertices snap
    constexpr double kSnapVolume = 0.01; // of the body: what snapping may change on flat faces and interfaces

    using FaceKey = std::array<VertexId, 3>;

    Vec3 point(const TetMesh& mesh, VertexId v) { return mesh.vertices.row(v).transpose(); }

    std::map<Label, double> volumes(const TetMesh& mesh)
    {
        std::map<Label, double> volume;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            volume[mesh.labels[static_cast<std::size_t>(t)]] += tet_volume(mesh, t);
        return volume;
    }

    double total_volume(const TetMesh& mesh)
    {
        double total = 0.0;
        for (const auto& [label, volume] : volumes(mesh))
            total += volume;
        return total;
    }

    struct Compact {
        explicit Compact(const CutSession& session)
            : mesh(session.compact_mesh(&map))
            , lips(session.lips())
        {
            for (LipFace& lip : lips)
                lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
        }
        SlotMap map;
        TetMesh mesh;
        std::vector<LipFace> lips; ///< ids of `mesh`
    };

    /// The boundary is closed and manifold: two faces at each edge, one fan of faces round each vertex.
    /// But for the vertices that are said to be pinched, which must be.
    void expect_manifold_boundary(const TetMesh& mesh, const std::set<VertexId>& pinched)
    {
        std::map<std::pair<VertexId, VertexId>, int> edges;
        std::map<VertexId, std::map<VertexId, VertexId>> link; // round each vertex: from one neighbour to the next
        for (const TetFace& face : boundary_faces(mesh)) {
            const auto v = face_vertices(mesh, face);
            for (std::size_t i = 0; i < 3; ++i) {
                ++edges[std::minmax(v[i], v[(i + 1) % 3])];
                const bool fresh = link[v[i]].emplace(v[(i + 1) % 3], v[(i + 2) % 3]).second;
                ASSERT_TRUE(fresh || pinched.contains(v[i])) << "vertex " << v[i];
            }
        }
        for (const auto& [edge, count] : edges)
            ASSERT_EQ(count, 2) << edge.first << " - " << edge.second;
        for (const auto& [v, next] : link) {
            std::size_t steps = 0;
            VertexId at = next.begin()->first;
            do {
                at = next.at(at);
                ++steps;
            } while (at != next.begin()->first && steps <= next.size());
            ASSERT_EQ(steps != next.size(), pinched.contains(v)) << "fans round vertex " << v;
        }
    }

    /// V - E + F - T of the mesh: 1 for a ball, 2 for two.
    long euler_characteristic(const TetMesh& mesh)
    {
        std::set<std::array<VertexId, 2>> edges;
        std::set<FaceKey> faces;
        std::set<VertexId> vertices;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto n = mesh.tet(t);
            vertices.insert(n.begin(), n.end());
            for (const auto& e : kTetEdges) {
                const auto [a, b] = std::minmax(n[static_cast<std::size_t>(e[0])], n[static_cast<std::size_t>(e[1])]);
                edges.insert({ a, b });
            }
            for (int corner = 0; corner < 4; ++corner) {
                FaceKey key = face_vertices(mesh, { t, corner });
                std::sort(key.begin(), key.end());
                faces.insert(key);
            }
        }
        return static_cast<long>(vertices.size()) - static_cast<long>(edges.size()) + static_cast<long>(faces.size())
            - static_cast<long>(mesh.tet_count());
    }

    int piece_count(const TetMesh& mesh)
    {
        const auto pieces = connected_pieces(mesh);
        return 1 + *std::max_element(pieces.begin(), pieces.end());
    }

    /// What holds after every cut, however it went.
    void expect_sound(const CutSession& session)
    {
        const Compact c(session);
        ASSERT_NO_THROW(check_mesh(c.mesh));
        EXPECT_EQ(c.mesh.tet_count(), session.tet_count());
        EXPECT_EQ(c.mesh.vertex_count(), session.vertex_count());
        std::set<VertexId> pinched;
        for (const VertexId v : test_support::pinched_vertices(session))
            pinched.insert(c.map.compact_vertex[static_cast<std::size_t>(v)]);
        expect_manifold_boundary(c.mesh, pinched);
        std::set<std::pair<TetId, int>> boundary;
        for (const TetFace& face : boundary_faces(c.mesh))
            boundary.emplace(face.tet, face.corner);
        for (const LipFace& lip : c.lips)
            EXPECT_TRUE(boundary.contains({ lip.face.tet, lip.face.corner }));
    }

    using Corners = std::array<std::array<double, 3>, 3>;

    Corners sorted_corners(const TetMesh& mesh, const TetFace& face)
    {
        Corners corners;
        const auto v = face_vertices(mesh, face);
        for (std::size_t i = 0; i < 3; ++i)
            corners[i] = { mesh.vertices(v[i], 0), mesh.vertices(v[i], 1), mesh.vertices(v[i], 2) };
        std::sort(corners.begin(), corners.end());
        return corners;
    }

    /// The two lips of one cut in a body without other cuts: mirror images that share the front only.
    /// @param border how far from the blade's border (mm) their common rim may be.
    void expect_lips_separate(const Compact& c, const SweptBlade& blade, double border = 0.0)
    {
        std::array<std::vector<Corners>, 2> faces;
        std::array<std::set<VertexId>, 2> vertices;
        const double size = std::max(blade.length(), blade.depth());
        for (const LipFace& lip : c.lips) {
            const std::size_t side = lip.side > 0 ? 1 : 0;
            faces[side].push_back(sorted_corners(c.mesh, lip.face));
            for (const VertexId v : face_vertices(c.mesh, lip.face)) {
                vertices[side].insert(v);
                EXPECT_LE(std::abs(blade.coordinates(point(c.mesh, v)).side), kOnBlade * size);
            }
            Vec3 centroid = Vec3::Zero();
            for (const VertexId v : c.mesh.tet(lip.face.tet))
                centroid += 0.25 * point(c.mesh, v);
            EXPECT_GT(blade.coordinates(centroid).side * lip.side, 0.0);
        }
        for (auto& side : faces)
            std::sort(side.begin(), side.end());
        EXPECT_FALSE(faces[0].empty());
        EXPECT_EQ(faces[0], faces[1]);
        for (const VertexId v : vertices[0])
            if (vertices[1].contains(v)) {
                const BladeCoordinates at = blade.coordinates(point(c.mesh, v));
                const double inside = std::max({ -at.along, at.along - blade.length(), at.depth - blade.depth() });
                EXPECT_NEAR(inside, 0.0, border + kOnBlade * size) << "the lips hang together within the blade";
            }
    }

    std::vector<Vec3> line_through(const Vec3& centre, const Vec3& along, double length, int segments)
    {
        std::vector<Vec3> line;
        for (int i = 0; i <= segments; ++i)
            line.push_back(centre + length * (static_cast<double>(i) / segments - 0.5) * along);
        return line;
    }

    /// The blade of the speed figures: heading 7.3 degrees, tilt 10 degrees, off the grid by (1.3, 0.9).
    Blade oblique_blade(const Vec3& top_centre, double length, double depth)
    {
        const double heading = 7.3 * std::numbers::pi / 180.0, tilt = 10.0 * std::numbers::pi / 180.0;
        const Vec3 along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
        Blade blade;
        blade.line = line_through(top_centre + Vec3(1.3, 0.9, 0.0), along, length, 12);
        blade.directions = { -std::cos(tilt) * Vec3::UnitZ() + std::sin(tilt) * across };
        blade.depth_mm = depth;
        return blade;
    }

    /// A box of 12,000 elements in three layers: skin, muscle, bone.
    TetMesh layered_box(int nx = 20, int ny = 20, int nz = 5, double spacing = 4.0)
    {
        TetMesh box = kuhn_box(nx, ny, nz, spacing);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            double z = 0.0;
            for (const VertexId v : box.tet(t))
                z += 0.25 * box.vertices(v, 2) / spacing / nz;
            box.labels[static_cast<std::size_t>(t)] = z > 0.8 ? Label { 3 } : z > 0.4 ? Label { 2 } : Label { 1 };
        }
        return box;
    }

    struct Snapshot {
        explicit Snapshot(const CutSession& session)
            : compact(session)
        {
            for (const TetId t : compact.map.tet_slot)
                origins.push_back(session.origin(t));
        }
        Compact compact;
        std::vector<TetId> origins;
    };

    void expect_identical(const Snapshot& a, const Snapshot& b)
    {
        const TetMesh &p = a.compact.mesh, &q = b.compact.mesh;
        ASSERT_EQ(p.vertices.rows(), q.vertices.rows());
        EXPECT_TRUE((p.vertices.array() == q.vertices.array()).all());
        EXPECT_EQ(p.nodes, q.nodes);
        EXPECT_EQ(p.labels, q.labels);
        EXPECT_EQ(a.origins, b.origins);
        EXPECT_EQ(a.compact.map.vertex_slot, b.compact.map.vertex_slot);
        EXPECT_EQ(a.compact.map.tet_slot, b.compact.map.tet_slot);
        EXPECT_EQ(a.compact.map.compact_vertex, b.compact.map.compact_vertex);
        EXPECT_EQ(a.compact.map.compact_tet, b.compact.map.compact_tet);
        ASSERT_EQ(a.compact.lips.size(), b.compact.lips.size());
        for (std::size_t i = 0; i < a.compact.lips.size(); ++i) {
            const LipFace &l = a.compact.lips[i], &m = b.compact.lips[i];
            EXPECT_TRUE(
                l.face.tet == m.face.tet && l.face.corner == m.face.corner && l.side == m.side && l.cut == m.cut);
        }
    }

    Blade random_blade(std::mt19937& random, const Vec3& extent)
    {
        std::uniform_real_distribution<double> unit(0.0, 1.0), lean(-0.6, 0.6);
        const auto on_top = [&] {
            return Vec3((1.4 * unit(random) - 0.2) * extent.x(), (1.4 * unit(random) - 0.2) * extent.y(), extent.z());
        };
        Blade blade;
        const int points = 2 + static_cast<int>(unit(random) * 2.0);
        const Vec3 a = on_top(), b = on_top();
        for (int i = 0; i < points; ++i)
            blade.line.push_back(a + (b - a) * i / (points - 1) + 0.6 * Vec3(lean(random), lean(random), lean(random)));
        blade.directions = { { lean(random), lean(random), -1.0 } };
        blade.depth_mm = 0.5 + 1.2 * extent.z() * unit(random);
        if (unit(random) < 0.3) // on the grid
            for (Vec3& p : blade.line)
                p = p.array().round();
        return blade;
    }

    /// A mesh kept by deltas alone, as FEM and view keep theirs.
    struct Follower {
        /// @param off_edge how far a vertex may be born from the place that its parents tell, mm: an edge of the grid.
        explicit Follower(const CutSession& session, double off_edge = std::sqrt(3.0))
            : off_edge_mm(off_edge)
        {
            const Compact c(session);
            for (std::size_t v = 0; v < c.map.vertex_slot.size(); ++v)
                vertices[c.map.vertex_slot[v]] = point(c.mesh, static_cast<VertexId>(v));
            for (std::size_t t = 0; t < c.map.tet_slot.size(); ++t) {
                std::array<VertexId, 4> nodes {};
                for (std::size_t i = 0; i < 4; ++i)
                    nodes[i] = c.map.vertex_slot[static_cast<std::size_t>(c.mesh.tet(static_cast<TetId>(t))[i])];
                tets[c.map.tet_slot[t]] = nodes;
            }
        }
        void follow(const MeshDelta& delta)
        {
            for (const auto& born : delta.vertices_born) {
                if (born.origin == MeshDelta::Origin::restored) {
                    EXPECT_TRUE(born.a == born.id && born.b == born.id && born.t == 0.0);
                    ++restored;
                } else {
                    EXPECT_NE(born.a, born.id);
                    EXPECT_NE(born.b, born.id);
                    EXPECT_TRUE(born.a != born.b || born.t == 0.0);
                    const Vec3 expected = (1.0 - born.t) * vertices.at(born.a) + born.t * vertices.at(born.b);
                    EXPECT_LE((expected - born.position).norm(), off_edge_mm);
                }
                ASSERT_TRUE(vertices.emplace(born.id, born.position).second);
            }
            for (const auto& moved : delta.vertices_moved) {
                ASSERT_EQ(vertices.at(moved.id), moved.from);
                vertices[moved.id] = moved.to;
            }
            for (const auto& born : delta.vertices_born)
                if (born.origin == MeshDelta::Origin::copy) {
                    EXPECT_EQ(born.a, born.b);
                    EXPECT_EQ(vertices.at(born.id), vertices.at(born.a));
                    ++copies;
                }
            for (const auto& tet : delta.tets_gone) {
                ASSERT_EQ(tets.at(tet.id), tet.nodes);
                tets.erase(tet.id);
            }
            for (const auto& tet : delta.tets_born)
                ASSERT_TRUE(tets.emplace(tet.id, tet.nodes).second);
            for (const auto& gone : delta.vertices_gone)
                ASSERT_EQ(vertices.erase(gone.id), 1u);
        }
        bool operator==(const Follower& other) const { return vertices == other.vertices && tets == other.tets; }
        double off_edge_mm;
        std::size_t copies = 0, restored = 0; ///< met
        std::map<VertexId, Vec3> vertices;
        std::map<TetId, std::array<VertexId, 4>> tets;
    };

    class ObliqueCut : public testing::TestWithParam<double> { };

    TEST_P(ObliqueCut, LiesOnTheBladeAndKeepsTheBody)
    {
        const TetMesh box = layered_box();
        const Blade blade = oblique_blade({ 40, 40, 20 }, 60.0, 12.0);
        const SweptBlade swept(blade);
        CutSession session(box);
        const CutResult result = session.cut(blade, { .snap = GetParam() });
        ASSERT_EQ(result.status, CutStatus::done) << result.message;
        expect_sound(session);
        const Compact c(session);
        const double border = GetParam() == 0.0 ? 60.0 * kOnBlade : kSnappedBorder * 4.0;
        expect_lips_separate(c, swept, border);

        // The wound is the whole rectangle, to its corners.
        EXPECT_NEAR(result.report.lip_area_mm2, 60.0 * 12.0, border * (60.0 + 2.0 * 12.0));
        double deepest = 0.0, first = 1e9, last = -1e9;
        for (const LipFace& lip : c.lips)
            for (const VertexId v : face_vertices(c.mesh, lip.face)) {
                const BladeCoordinates at = swept.coordinates(point(c.mesh, v));
                deepest = std::max(deepest, at.depth);
                first = std::min(first, at.along);
                last = std::max(last, at.along);
            }
        EXPECT_NEAR(deepest, 12.0, border);
        EXPECT_NEAR(first, 0.0, border);
        EXPECT_NEAR(last, 60.0, border);

        // One piece still, and a ball: a slit that ends inside makes no hole.
        EXPECT_EQ(piece_count(c.mesh), 1);
        EXPECT_EQ(euler_characteristic(c.mesh), 1);

        const double tolerance = GetParam() == 0.0 ? kRoundOff : kSnapVolume;
        const auto before = volumes(box), after = volumes(c.mesh);
        for (const auto& [label, volume] : before)
            EXPECT_NEAR(after.at(label), volume, tolerance * volume) << "label " << label;
        EXPECT_NEAR(total_volume(c.mesh), total_volume(box), tolerance * total_volume(box));

        const CutReport& r = result.report;
        EXPECT_EQ(r.tets_before, box.tet_count());
        EXPECT_EQ(r.tets_after, c.mesh.tet_count());
        EXPECT_EQ(r.tets_after, r.tets_before + result.delta.tets_born.size() - result.delta.tets_gone.size());
        EXPECT_GT(r.tets_crossed, 200u);
        EXPECT_EQ(r.vertices_moved == 0, GetParam() == 0.0);
        EXPECT_LE(r.largest_move_mm, 0.5 * 4.0); // half of the shortest edge
    }

    INSTANTIATE_TEST_SUITE_P(Snap, ObliqueCut, testing::Values(0.0, 0.15, 0.3));

    TEST(CutSession, ChildrenFillTheirOrigin)
    {
        const TetMesh box = layered_box(10, 10, 4, 4.0);
        CutSession session(box);
        ASSERT_EQ(session.cut(oblique_blade({ 20, 20, 16 }, 24.0, 9.0), { .snap = 0.0 }).status, CutStatus::done);
        const Compact c(session);
        std::vector<double> filled(box.tet_count(), 0.0);
        for (TetId t = 0; t < static_cast<TetId>(c.mesh.tet_count()); ++t) {
            const TetId origin = session.origin(c.map.tet_slot[static_cast<std::size_t>(t)]);
            filled[static_cast<std::size_t>(origin)] += tet_volume(c.mesh, t);
            EXPECT_EQ(c.mesh.labels[static_cast<std::size_t>(t)], box.labels[static_cast<std::size_t>(origin)]);
            // Every corner of the child lies in its origin: no barycentric coordinate is negative.
            const auto n = box.tet(origin);
            for (const VertexId v : c.mesh.tet(t))
                for (std::size_t k = 0; k < 4; ++k) {
                    std::array<Vec3, 4> p;
                    for (std::size_t i = 0; i < 4; ++i)
                        p[i] = i == k ? point(c.mesh, v) : point(box, n[i]);
                    EXPECT_GE(tet_volume(p[0], p[1], p[2], p[3]), -kRoundOff * 64.0);
                }
        }
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            EXPECT_NEAR(filled[static_cast<std::size_t>(t)], tet_volume(box, t), kRoundOff * 64.0);
        EXPECT_THROW(static_cast<void>(session.origin(-1)), InputError);
        EXPECT_THROW(static_cast<void>(session.origin(1 << 30)), InputError);
    }

    TEST(CutSession, AThroughCutDividesTheBoxByTheClosedForm)
    {
        // Plane x = 17.3 + 0.1 y - 0.2 (z - 16) through a box of 40 x 40 x 16.
        const TetMesh box = kuhn_box(10, 10, 4, 4.0);
        const Blade blade { .line = { { 17.3 - 1.0, -10, 16 }, { 17.3 + 5.0, 50, 16 } },
            .directions = { { 0.2, 0, -1.0 } },
            .depth_mm = 30.0 };
        CutSession session(box);
        const CutResult result = session.cut(blade, { .snap = 0.0 });
        ASSERT_EQ(result.status, CutStatus::done);
        expect_sound(session);
        const Compact c(session);
        const auto pieces = connected_pieces(c.mesh);
        std::array<double, 2> volume { 0.0, 0.0 };
        for (TetId t = 0; t < static_cast<TetId>(c.mesh.tet_count()); ++t) {
            ASSERT_LT(pieces[static_cast<std::size_t>(t)], 2);
            volume[static_cast<std::size_t>(pieces[static_cast<std::size_t>(t)])] += tet_volume(c.mesh, t);
        }
        std::sort(volume.begin(), volume.end());
        const double mean_x = 17.3 + 0.1 * 20.0 - 0.2 * (8.0 - 16.0);
        const double smaller = std::min(mean_x, 40.0 - mean_x) * 40.0 * 16.0;
        EXPECT_NEAR(volume[0], smaller, 1e-10 * smaller);
        EXPECT_NEAR(volume[0] + volume[1], 40.0 * 40.0 * 16.0, 1e-7);
        EXPECT_EQ(euler_characteristic(c.mesh), 2);
        EXPECT_NEAR(result.report.lip_area_mm2, 40.0 * 16.0 * std::sqrt(1.0 + 0.01 + 0.04), 1e-8);
    }

    TEST(CutSession, ABladeWithKinksIsFollowed)
    {
        const TetMesh box = layered_box(12, 12, 4, 4.0);
        for (const double snap : { 0.0, 0.15 }) {
            Blade blade { .line = { { 9.1, 10.2, 16 }, { 20.3, 17.4, 16 }, { 29.7, 16.1, 16 }, { 38.4, 30.3, 16 } },
                .directions = { { 0.1, 0.2, -1 }, { 0, 0.2, -1 }, { -0.1, 0.1, -1 }, { 0, 0, -1 } },
                .depth_mm = 9.3 };
            const SweptBlade swept(blade);
            CutSession session(box);
            const CutResult result = session.cut(blade, { .snap = snap, .crease_deg = 0.0 });
            ASSERT_EQ(result.status, CutStatus::done);
            expect_sound(session);
            const Compact c(session);
            const double border = snap == 0.0 ? 0.0 : 0.1 * 4.0; // of an edge: as guaranteed
            expect_lips_separate(c, swept, border);
            EXPECT_EQ(piece_count(c.mesh), 1);
            EXPECT_EQ(euler_characteristic(c.mesh), 1);
            double deepest = 0.0;
            for (const LipFace& lip : c.lips)
                for (const VertexId v : face_vertices(c.mesh, lip.face))
                    deepest = std::max(deepest, swept.coordinates(point(c.mesh, v)).depth);
            EXPECT_NEAR(deepest, 9.3, border + swept.length() * kOnBlade);
            double area = 0.0; // of the blade below the skin
            for (const auto& t : swept.surface().triangles) {
                const Vec3 a = swept.surface().vertices.row(t[0]), b = swept.surface().vertices.row(t[1]),
                           d = swept.surface().vertices.row(t[2]);
                if (std::max({ a.z(), b.z(), d.z() }) < 16.0 + 1e-9)
                    area += 0.5 * (b - a).cross(d - a).norm();
            }
            // Bends are edges of the mesh, so that the wound is the blade to round-off; snapping carries the skin away
            // by 0.05 edges at most, along all of the blade's length.
            EXPECT_NEAR(result.report.lip_area_mm2, area, snap == 0.0 ? 1e-9 * area : 0.05 * 4.0 * swept.length());
            const double tolerance = snap == 0.0 ? kRoundOff : kSnapVolume;
            EXPECT_NEAR(total_volume(c.mesh), total_volume(box), tolerance * total_volume(box));
        }
    }

    TEST(CutSession, ABladeRoundTheChestIsFollowed)
    {
        // A quarter of a ring, cut by an arc of 60 degrees whose directions follow the skin's normal and lean.
        TetMesh ring = layered_box(30, 8, 5, 4.0);
        for (Eigen::Index v = 0; v < ring.vertices.rows(); ++v) {
            const double angle = ring.vertices(v, 0) / 120.0 * 0.5 * std::numbers::pi,
                         radius = 60.0 + ring.vertices(v, 2);
            ring.vertices.row(v) << radius * std::sin(angle), ring.vertices(v, 1), radius * std::cos(angle);
        }
        Blade blade;
        blade.depth_mm = 13.0;
        for (int i = 0; i <= 15; ++i) {
            const double angle = (15.0 + 4.0 * i) * std::numbers::pi / 180.0;
            const Vec3 out(std::sin(angle), 0.0, std::cos(angle));
            blade.line.push_back(80.0 * out + 14.3 * Vec3::UnitY());
            blade.directions.push_back(-out + 0.2 * Vec3::UnitY());
        }
        const SweptBlade swept(blade);
        for (const double snap : { 0.0, 0.15 }) {
            CutSession session(ring);
            ASSERT_EQ(session.cut(blade, { .snap = snap }).status, CutStatus::done);
            expect_sound(session);
            const Compact c(session);
            expect_lips_separate(c, swept);
            EXPECT_EQ(piece_count(c.mesh), 1);
            EXPECT_EQ(euler_characteristic(c.mesh), 1);
            double deepest = 0.0, first = 1e9, last = -1e9;
            for (const LipFace& lip : c.lips)
                for (const VertexId v : face_vertices(c.mesh, lip.face)) {
                    const BladeCoordinates at = swept.coordinates(point(c.mesh, v));
                    deepest = std::max(deepest, at.depth);
                    first = std::min(first, at.along);
                    last = std::max(last, at.along);
                }
            EXPECT_NEAR(deepest, 13.0, kOnBlade * swept.length());
            EXPECT_NEAR(first, 0.0, kOnBlade * swept.length());
            EXPECT_NEAR(last, swept.length(), kOnBlade * swept.length());
        }
    }

    TEST(CutSession, ABladeAlongTheGridMovesAndSplitsLittle)
    {
        // In a plane of the grid, from vertex to vertex, down to a layer: faces only, nothing to split.
        const TetMesh box = kuhn_box(8, 8, 4, 4.0);
        const Blade along_faces {
            .line = { { 8, 16, 16 }, { 24, 16, 16 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 8.0
        };
        CutSession session(box);
        CutResult result = session.cut(along_faces, { .snap = 0.0 });
        ASSERT_EQ(result.status, CutStatus::done);
        expect_sound(session);
        EXPECT_EQ(result.report.tets_crossed, 0u);
        EXPECT_NEAR(result.report.lip_area_mm2, 16.0 * 8.0, 1e-9);
        EXPECT_LE(session.tet_count(), box.tet_count() + 8); // the wound's two corners are opened
        expect_lips_separate(Compact(session), SweptBlade(along_faces));
        // Along diagonals of the cubes, where faces and edges of the Kuhn pattern lie.
        const Blade diagonal {
            .line = { { 2, 2, 16 }, { 31, 31, 16 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 7.0
        };
        CutSession other(box);
        result = other.cut(diagonal, { .snap = 0.0 });
        ASSERT_EQ(result.status, CutStatus::done);
        expect_sound(other);
        EXPECT_NEAR(result.report.lip_area_mm2, std::sqrt(2.0) * 29.0 * 7.0, 1e-8);
        // The other diagonal: across edges, through vertices.
        const Blade across {
            .line = { { 2, 30, 16 }, { 30, 2, 16 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 7.0
        };
        CutSession third(box);
        result = third.cut(across, { .snap = 0.15 });
        ASSERT_EQ(result.status, CutStatus::done);
        expect_sound(third);
        EXPECT_NEAR(result.report.lip_area_mm2, std::sqrt(2.0) * 28.0 * 7.0, 1e-8);
    }

    TEST(CutSession, CrossingCutsMakeFourCorners)
    {
        const TetMesh box = kuhn_box(10, 10, 4, 4.0);
        CutSession session(box);
        const Blade first {
            .line = { { -5, 19.1, 16 }, { 45, 21.3, 16 } }, .directions = { { 0, 0.1, -1 } }, .depth_mm = 30.0
        };
        const Blade second {
            .line = { { 18.7, -5, 16 }, { 20.2, 45, 16 } }, .directions = { { 0.1, 0, -1 } }, .depth_mm = 30.0
        };
        ASSERT_EQ(session.cut(first, { .snap = 0.0 }).status, CutStatus::done);
        const std::size_t lips_of_first = session.lips().size();
        ASSERT_EQ(session.cut(second, { .snap = 0.0 }).status, CutStatus::done);
        expect_sound(session);
        const Compact c(session);
        EXPECT_EQ(piece_count(c.mesh), 4);
        EXPECT_EQ(euler_characteristic(c.mesh), 4);
        EXPECT_NEAR(total_volume(c.mesh), total_volume(box), kRoundOff * total_volume(box));
        // The first cut's lips were split by the second, and are all still there.
        std::size_t count = 0;
        std::map<int, double> area;
        for (const LipFace& lip : c.lips) {
            count += lip.cut == 0 ? 1 : 0;
            const auto v = face_vertices(c.mesh, lip.face);
            area[lip.cut] += 0.25
                * (point(c.mesh, v[1]) - point(c.mesh, v[0])).cross(point(c.mesh, v[2]) - point(c.mesh, v[0])).norm();
        }
        EXPECT_GT(count, lips_of_first);
        EXPECT_NEAR(area[0], 40.0 * 16.0 * std::sqrt(1.0 + 0.01 + std::pow(2.2 / 50.0, 2)), 1e-7);
        EXPECT_EQ(session.cut_count(), 2u);
    }

    TEST(CutSession, ElementsMuchFlatterThanTheirParentsAreCountedAndTold)
    {
        // Nothing is snapped and the blade grazes a layer of vertices: slivers are the answer.
        CutSession grazing(layered_box());
        Blade blade {
            .line = { { 10, 40, 20.03 }, { 50, 40, 20.03 } }, .directions = { { 0, 0.01, -1 } }, .depth_mm = 12.0
        };
        blade.line[0].y() += 0.02;
        const CutResult flat = grazing.cut(blade, { .snap = 0.0 });
        ASSERT_EQ(flat.status, CutStatus::done);
        EXPECT_LT(flat.report.worst_dihedral_deg, 6.0);
        EXPECT_GT(flat.report.tets_below_half_parent, 0u);
        EXPECT_NE(flat.message.find("flatter than half"), std::string::npos) << flat.message;
        EXPECT_NE(flat.message.find("the blade grazes them"), std::string::npos) << flat.message;
        // A bound that is missed is told, also where the elements were as flat before.
        TetMesh low = layered_box();
        low.vertices.col(2) *= 0.04; // angles of some 2 degrees
        CutSession flattened(low);
        const CutResult missed = flattened.cut(
            { .line = { { 10, 41, 0.8 }, { 50, 38, 0.8 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 2.0 });
        ASSERT_EQ(missed.status, CutStatus::done) << missed.message;
        EXPECT_LT(missed.report.worst_dihedral_deg, 5.0);
        EXPECT_NE(missed.message.find("asked are 5 and 8"), std::string::npos) << missed.message;
        // With snapping the same blade moves those vertices, and there is nothing to tell.
        CutSession snapping(layered_box());
        const CutResult good = snapping.cut(blade);
        ASSERT_EQ(good.status, CutStatus::done);
        EXPECT_EQ(good.report.tets_below_half_parent, 0u) << good.message;
        EXPECT_TRUE(good.message.empty()) << good.message;
    }

    TEST(CutSession, TheSameCutAgainFindsNothingToCut)
    {
        CutSession session(layered_box());
        const Blade blade = oblique_blade({ 40, 40, 20 }, 60.0, 12.0);
        ASSERT_EQ(session.cut(blade).status, CutStatus::done);
        const std::size_t tets = session.tet_count(), lips = session.lips().size();
        const CutResult again = session.cut(blade);
        EXPECT_EQ(again.status, CutStatus::missed_body);
        EXPECT_FALSE(again.message.empty());
        EXPECT_EQ(session.tet_count(), tets);
        EXPECT_EQ(session.lips().size(), lips);
        EXPECT_EQ(session.cut_count(), 1u);
        // Deeper: the wound goes on from where it ended.
        Blade deeper = blade;
        deeper.depth_mm = 16.0;
        const CutResult more = session.cut(deeper, { .snap = 0.0 });
        ASSERT_EQ(more.status, CutStatus::done);
        expect_sound(session);
        EXPECT_NEAR(more.report.lip_area_mm2, 60.0 * 4.0, kSnappedBorder * 4.0 * (60.0 + 2.0 * 12.0));
    }

    TEST(CutSession, ElementsNearACutStayHealthy)
    {
        // The bench's stroke: SOFA-size elements, oblique to the grid.
        CutSession session(layered_box());
        const CutReport r = session.cut(oblique_blade({ 41.3, 40.9, 20 }, 60.0, 12.0)).report;
        EXPECT_LE(r.mean_increase(), 3.6);
        EXPECT_DOUBLE_EQ(r.mean_increase() * static_cast<double>(r.tets_crossed),
            static_cast<double>(r.tets_after) - static_cast<double>(r.tets_before));
        EXPECT_GE(r.worst_dihedral_deg, 5.0);
        EXPECT_GE(r.p01_dihedral_deg, 8.0);
        EXPECT_GE(r.p01_dihedral_deg, r.worst_dihedral_deg);
        EXPECT_NEAR(r.worst_dihedral_before_deg, 45.0, 1e-9);
        EXPECT_LE(r.lip_to_blade, 1e-9); // a flat blade
        EXPECT_LE(r.surface_deviation, 0.05);
        EXPECT_GT(r.smallest_volume_ratio, 0.0);
        EXPECT_LT(r.smallest_volume_ratio, 1.0);
    }

    TEST(CutSession, AStrokeThatMissesAPromiseIsMadeAgainWithMoreCare)
    {
        // Both wings of the blade cross elements that the bend between them passes by: at first their chords lie
        // further off the blade than 0.1 local edges.
        const TetMesh box = kuhn_box(6, 6, 4, 4.0);
        const Blade blade { .line = { { 5, 15.7, 16 }, { 14.7, 8.3, 16 }, { 18.8, 16.4, 16 } },
            .directions = { { 0, 0.3, -1 } },
            .depth_mm = 9.1 };
        CutSession session(box);
        const CutResult result = session.cut(blade);
        ASSERT_EQ(result.status, CutStatus::done);
        EXPECT_GT(result.report.attempts, 1);
        EXPECT_NE(result.message.find("attempt"), std::string::npos) << result.message; // nothing silently
        expect_sound(session);
        const SweptBlade swept(blade);
        const double local_edge = 4.0 * (3.0 + 2.0 * std::sqrt(2.0) + std::sqrt(3.0)) / 6.0; // of a Kuhn element
        const Compact c(session);
        for (const LipFace& lip : c.lips) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : face_vertices(c.mesh, lip.face))
                middle += point(c.mesh, v) / 3.0;
            EXPECT_LE((swept.project(middle) - middle).norm(), 0.1 * local_edge);
        }
        // What failed left nothing behind: the same stroke gives the same bits, and undo the first mesh.
        CutSession again(box);
        ASSERT_EQ(again.cut(blade).status, CutStatus::done);
        EXPECT_EQ(again.compact_mesh().nodes, c.mesh.nodes);
        EXPECT_EQ((again.compact_mesh().vertices - c.mesh.vertices).cwiseAbs().maxCoeff(), 0.0);
        (void)session.undo();
        EXPECT_EQ(session.compact_mesh().nodes, box.nodes);
        EXPECT_EQ((session.compact_mesh().vertices - box.vertices).cwiseAbs().maxCoeff(), 0.0);
    }

    /// A straight blade whose direction turns about the line by this angle from end to end.
    Blade twisted_blade(const Vec3& top_centre, double length, double depth, double turn_deg, int points)
    {
        Blade blade { .line = {}, .directions = {}, .depth_mm = depth };
        for (int i = 0; i < points; ++i) {
            const double share = static_cast<double>(i) / (points - 1) - 0.5;
            const double angle = share * turn_deg * std::numbers::pi / 180.0;
            blade.line.push_back(top_centre + share * length * Vec3::UnitX());
            blade.directions.emplace_back(0.01, std::sin(angle), -std::cos(angle));
        }
        return blade;
    }

    TEST(CutSession, ATwistedBladeIsFollowedByHalvedElements)
    {
        constexpr double kLocalEdge = 5.0; // mm; the edges of a Kuhn cube are longer
        constexpr double kMostPerElement = 80.0;
        const TetMesh box = kuhn_box(6, 6, 6, kLocalEdge);
        for (const int points : { 2, 4, 9 }) {
            CutSession session(box);
            const Blade blade = twisted_blade({ 15.13, 15.3, 30.0 }, 6.0, 18.0, 25.0, points);
            const CutResult result = session.cut(blade);
            ASSERT_EQ(result.status, CutStatus::done) << result.message;
            EXPECT_GT(result.report.attempts, 1);
            EXPECT_LE(static_cast<double>(result.report.tets_created),
                kMostPerElement * static_cast<double>(result.report.tets_crossed));
            expect_sound(session);
            const SweptBlade swept(blade);
            const Compact c(session);
            double off = 0.0;
            for (const LipFace& lip : c.lips) {
                const auto v = face_vertices(c.mesh, lip.face);
                const Vec3 middle = (point(c.mesh, v[0]) + point(c.mesh, v[1]) + point(c.mesh, v[2])) / 3.0;
                off = std::max(off, (swept.project(middle) - middle).norm());
            }
            EXPECT_LE(off, 0.1 * 1.26 * kLocalEdge) << points << " points"; // 1.26: the mean edge of a Kuhn element
        }
    }

    TEST(CutSession, ABladeThatTwistsTooMuchIsRefusedBeforeItMakesTooManyElements)
    {
        CutSession session(kuhn_box(6, 6, 6, 10.0));
        const Snapshot before(session);
        try {
            static_cast<void>(session.cut(twisted_blade({ 30.13, 30.6, 60.0 }, 1.0, 36.0, 60.0, 9)));
            FAIL() << "it was cut";
        } catch (const CutQualityError& refusal) {
            EXPECT_EQ(refusal.kind(), CutQualityError::Kind::growth);
            const std::string text = refusal.what();
            EXPECT_NE(text.find("twists or bends so much within single elements"), std::string::npos) << text;
            EXPECT_TRUE(text.ends_with("mesh finer there")) << "more attempts, or advice that does not fit: " << text;
        }
        expect_identical(before, Snapshot(session));
    }

    TEST(CutSession, AStrokeThatGrowsIsOneCut)
    {
        const TetMesh box = layered_box();
        CutSession session(box);
        Follower follower(session, 4.0);
        const Snapshot before(session);
        const Blade whole { .line = { { 12, 37, 20 }, { 17, 39, 20 }, { 22, 42, 20 }, { 27, 44, 20 }, { 32, 44, 20 },
                                { 37, 42, 20 }, { 42, 40, 20 } },
            .directions = { { 0.1, 0.1, -1.0 } },
            .depth_mm = 9.0 };
        const CutOptions options { .crease_deg = 30.0 };
        double drawn = 0.0;
        for (std::size_t points = 2; points <= whole.line.size(); ++points) {
            Blade so_far = whole;
            so_far.line.resize(points);
            const CutResult step = session.extend_stroke(so_far, options);
            ASSERT_EQ(step.status, CutStatus::done) << step.message;
            follower.follow(step.delta);
            ASSERT_EQ(follower, Follower(session));
            expect_sound(session);
            // Nothing is cut beyond the tip, and an element's length at most is left open behind it.
            const SweptBlade swept(so_far);
            double last = 0.0;
            const Compact c(session);
            for (const LipFace& lip : c.lips)
                for (const VertexId v : face_vertices(c.mesh, lip.face))
                    last = std::max(last, swept.coordinates(point(c.mesh, v)).along);
            EXPECT_LE(last, swept.length() + 1e-6);
            EXPECT_GE(last, swept.length() - 8.0);
            EXPECT_GE(last, drawn);
            drawn = last;
            EXPECT_THROW(static_cast<void>(session.undo()), InputError);
            EXPECT_THROW(static_cast<void>(session.cut(whole)), InputError);
        }
        ASSERT_TRUE(session.stroke_open());
        const CutResult end = session.finish_stroke();
        ASSERT_EQ(end.status, CutStatus::done);
        follower.follow(end.delta);
        EXPECT_EQ(follower, Follower(session));
        expect_sound(session);
        EXPECT_FALSE(session.stroke_open());
        const double area = SweptBlade(whole).length() * 9.0;
        EXPECT_NEAR(end.report.lip_area_mm2, area, 0.03 * area);
        EXPECT_LE(end.report.lip_to_blade, 0.1);
        EXPECT_EQ(session.cut_count(), 1u);
        const Snapshot after(session);
        follower.follow(session.undo());
        EXPECT_EQ(follower, Follower(session));
        expect_identical(Snapshot(session), before);
        follower.follow(session.redo());
        EXPECT_EQ(follower, Follower(session));
        expect_identical(Snapshot(session), after);
        EXPECT_THROW(static_cast<void>(session.finish_stroke()), InputError);
    }

    TEST(CutSession, UncutBoneStaysTied)
    {
        TetMesh box = kuhn_box(10, 10, 4, 4.0, 1);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) { // a bar across the blade
            Vec3 centroid = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                centroid += 0.25 * point(box, v);
            if (centroid.x() > 16 && centroid.x() < 24 && centroid.z() > 4 && centroid.z() < 12)
                box.labels[static_cast<std::size_t>(t)] = 7;
        }
        const Blade blade {
            .line = { { -5, 19.1, 16 }, { 45, 21.3, 16 } }, .directions = { { 0, 0.1, -1 } }, .depth_mm = 30.0
        };
        CutSession session(box);
        const CutResult result = session.cut(blade, { .snap = 0.0, .uncut_labels = { 7 } });
        ASSERT_EQ(result.status, CutStatus::done);
        expect_sound(session);
        const Compact c(session);
        EXPECT_EQ(piece_count(c.mesh), 1);
        EXPECT_EQ(euler_characteristic(c.mesh), 1); // two halves held together by one bar: a ball
        for (const LipFace& lip : c.lips)
            EXPECT_NE(c.mesh.labels[static_cast<std::size_t>(lip.face.tet)], 7);
        const double slope = std::sqrt(1.0 + 0.01 + std::pow(2.2 / 50.0, 2));
        EXPECT_NEAR(result.report.lip_area_mm2, (40.0 * 16.0 - 8.0 * 8.0) * slope, 1e-7);
        CutSession severed(box);
        ASSERT_EQ(severed.cut(blade, { .snap = 0.0 }).status, CutStatus::done);
        EXPECT_EQ(piece_count(Compact(severed).mesh), 2);
    }

    TEST(CutSession, UndoAndRedoAreBitExact)
    {
        std::mt19937 random(2);
        CutSession session(layered_box(6, 6, 4, 1.0));
        std::vector<Snapshot> states { Snapshot(session) };
        std::vector<MeshDelta> deltas;
        while (deltas.size() < 6) {
            CutResult result = session.cut(random_blade(random, { 6, 6, 4 }));
            if (result.status == CutStatus::done) {
                deltas.push_back(std::move(result.delta));
                states.emplace_back(session);
            }
        }
        EXPECT_FALSE(session.can_redo());
        for (int round = 0; round < 2; ++round) {
            for (std::size_t i = deltas.size(); i > 0; --i) {
                const MeshDelta back = session.undo();
                EXPECT_EQ(back.tets_born.size(), deltas[i - 1].tets_gone.size());
                EXPECT_EQ(back.vertices_gone.size(), deltas[i - 1].vertices_born.size());
                expect_identical(Snapshot(session), states[i - 1]);
            }
            EXPECT_FALSE(session.can_undo());
            EXPECT_THROW(static_cast<void>(session.undo()), InputError);
            for (std::size_t i = 0; i < deltas.size(); ++i) {
                const MeshDelta again = session.redo();
                EXPECT_EQ(again.tets_born.size(), deltas[i].tets_born.size());
                expect_identical(Snapshot(session), states[i + 1]);
            }
            EXPECT_THROW(static_cast<void>(session.redo()), InputError);
        }
        // Undone cuts are forgotten by a new one, which gets the same ids as if they had never been.
        CutSession fresh(layered_box(6, 6, 4, 1.0));
        while (session.can_undo())
            static_cast<void>(session.undo());
        const Blade blade {
            .line = { { 1.1, 1.3, 4 }, { 4.6, 5.2, 4 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 2.2
        };
        ASSERT_EQ(session.cut(blade).status, CutStatus::done);
        ASSERT_EQ(fresh.cut(blade).status, CutStatus::done);
        EXPECT_FALSE(session.can_redo());
        expect_identical(Snapshot(session), Snapshot(fresh));
    }

    TEST(CutSession, DeltasAloneKeepAMeshInStep)
    {
        constexpr double kExact = 1e-8; // put on the blade to 1e-10 of its size
        for (const double snap : { 0.0, CutOptions {}.snap }) {
            std::mt19937 random(8);
            CutSession session(layered_box(6, 6, 4, 1.0));
            Follower follower(session, snap == 0.0 ? kExact : std::sqrt(3.0));
            for (int i = 0; i < 12; ++i) {
                follower.follow(session.cut(random_blade(random, { 6, 6, 4 }), { .snap = snap }).delta);
                ASSERT_EQ(follower, Follower(session)) << "cut " << i;
                if (i % 3 == 2) {
                    const MeshDelta back = session.undo();
                    follower.follow(back);
                    ASSERT_EQ(follower, Follower(session)) << "undo after cut " << i;
                    const MeshDelta there_and_back = inverse(inverse(back));
                    ASSERT_EQ(there_and_back.vertices_gone.size(), back.vertices_gone.size());
                    for (std::size_t k = 0; k < back.vertices_gone.size(); ++k)
                        EXPECT_EQ(there_and_back.vertices_gone[k].id, back.vertices_gone[k].id);
                }
            }
            EXPECT_GT(follower.copies, 100u);
            EXPECT_EQ(follower.restored, 0u);
        }
    }

    TEST(CutSession, DeltasTellCopiesFromVerticesOnEdgesAndFromThoseThatComeBack)
    {
        CutSession session(layered_box(6, 6, 4, 1.0));
        Follower follower(session);
        const auto all_of = [](const std::vector<MeshDelta::VertexBorn>& vertices, MeshDelta::Origin origin) {
            return std::all_of(vertices.begin(), vertices.end(), [&](const auto& v) { return v.origin == origin; });
        };
        const VertexId corner = 0;
        const CutResult ablation = session.ablate(session.tets_at(corner));
        ASSERT_EQ(ablation.status, CutStatus::done);
        follower.follow(ablation.delta);
        ASSERT_FALSE(ablation.delta.vertices_gone.empty());
        EXPECT_TRUE(all_of(ablation.delta.vertices_gone, MeshDelta::Origin::restored));
        const Blade blade {
            .line = { { -1, 3.2, 4 }, { 7, 3.3, 4 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 2.2
        };
        const CutResult cut = session.cut(blade);
        ASSERT_EQ(cut.status, CutStatus::done);
        EXPECT_TRUE(session.has_vertex(corner)); // the id is used again
        follower.follow(cut.delta);
        const std::size_t copies = follower.copies;
        EXPECT_GT(copies, 5u);
        const MeshDelta back = session.undo();
        EXPECT_FALSE(all_of(back.vertices_gone, MeshDelta::Origin::copy));
        EXPECT_FALSE(all_of(back.vertices_gone, MeshDelta::Origin::on_edge));
        follower.follow(back);
        const MeshDelta whole = session.undo();
        EXPECT_TRUE(all_of(whole.vertices_born, MeshDelta::Origin::restored));
        follower.follow(whole);
        EXPECT_EQ(follower.restored, ablation.delta.vertices_gone.size());
        EXPECT_EQ(follower, Follower(session));
        follower.follow(session.redo());
        follower.follow(session.redo());
        EXPECT_EQ(follower.copies, 2 * copies);
        EXPECT_EQ(follower, Follower(session));
    }

    TEST(CutSession, RandomStrokesKeepEveryInvariant)
    {
        std::mt19937 random(1);
        const Vec3 extent(5, 5, 3);
        const TetMesh box = layered_box(5, 5, 3, 1.0);
        const double volume = total_volume(box);
        std::size_t done = 0, refused = 0;
        for (int patient = 0; patient < 100; ++patient) {
            CutSession session(box);
            const double snap = patient % 3 == 0 ? 0.0 : patient % 3 == 1 ? 0.15 : 0.3;
            for (int stroke = 0; stroke < 4; ++stroke) {
                const Snapshot before(session);
                const Blade blade = random_blade(random, extent);
                try {
                    const CutResult result = session.cut(blade, { .snap = snap });
                    if (result.status == CutStatus::done)
                        ++done;
                    else
                        expect_identical(Snapshot(session), before);
                } catch (const Error& error) {
                    ++refused;
                    expect_identical(Snapshot(session), before);
                }
                SCOPED_TRACE("patient " + std::to_string(patient) + " stroke " + std::to_string(stroke));
                expect_sound(session);
                if (HasFatalFailure())
                    return;
            }
            EXPECT_NEAR(total_volume(session.compact_mesh()), volume, (snap == 0.0 ? 1e-11 : kSnapVolume) * volume);
        }
        EXPECT_GT(done, 250u);
        EXPECT_LE(refused, 8u);
    }

    TEST(CutSession, TwoRunsAreTheSame)
    {
        CutSession first(layered_box()), second(layered_box());
        for (const double shift : { 0.0, 3.0, 20.0 }) {
            const Blade blade = oblique_blade({ 40, 25 + shift, 20 }, 50.0, 13.0);
            ASSERT_EQ(first.cut(blade).status, CutStatus::done);
            ASSERT_EQ(second.cut(blade).status, CutStatus::done);
        }
        expect_identical(Snapshot(first), Snapshot(second));
    }

    TEST(CutSession, ACancelledOrMissedCutLeavesNoTrace)
    {
        CutSession session(layered_box());
        ASSERT_EQ(session.cut(oblique_blade({ 40, 50, 20 }, 30.0, 9.0)).status, CutStatus::done);
        const Snapshot before(session);
        const Blade blade = oblique_blade({ 40, 40, 20 }, 60.0, 12.0);
        for (const double stop_at : { 0.0, 0.3, 0.6, 1.0 }) {
            std::atomic<bool> cancel { false };
            Job job;
            job.cancel = &cancel;
            job.on_progress = [&](std::string_view, double fraction) {
                if (fraction >= stop_at)
                    cancel = true;
            };
            const CutResult result = session.cut(blade, {}, job);
            EXPECT_EQ(result.status, CutStatus::cancelled);
            EXPECT_TRUE(result.delta.tets_born.empty());
            expect_identical(Snapshot(session), before);
        }
        const CutResult outside = session.cut(oblique_blade({ 40, 200, 20 }, 60.0, 12.0));
        EXPECT_EQ(outside.status, CutStatus::missed_body);
        EXPECT_NE(outside.message.find("misses the body"), std::string::npos) << outside.message;
        expect_identical(Snapshot(session), before);
        EXPECT_EQ(session.cut_count(), 1u);
    }

    TEST(CutSession, WrongInputIsRefusedByName)
    {
        const TetMesh box = kuhn_box(2, 2, 2, 1.0);
        EXPECT_THROW(CutSession(with_midpoints(box)), InputError);
        TetMesh broken = box;
        broken.vertices(0, 0) = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(CutSession { broken }, InputError);
        CutSession session(box);
        Blade blade { .line = { { 0.3, 1.1, 2 }, { 1.7, 0.9, 2 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 1.2 };
        for (const double snap : { -0.1, 0.6, std::numeric_limits<double>::quiet_NaN() })
            try {
                static_cast<void>(session.cut(blade, { .snap = snap }));
                FAIL() << "snap " << snap << " was accepted";
            } catch (const InputError& error) {
                EXPECT_EQ(error.where(), "snap");
            }
        blade.depth_mm = -1.0;
        try {
            static_cast<void>(session.cut(blade));
            FAIL() << "a negative depth was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "depth_mm");
        }
        EXPECT_EQ(session.cut_count(), 0u);
    }

} // namespace cut_session_test
} // namespace retractor::mesh
