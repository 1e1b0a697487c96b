#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/pieces.h"
#include "tests/support/session_state.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace retractor::mesh {
namespace cut_ablation_test {

    constexpr double kRoundOff = 1e-12; // of a sum of some thousand volumes
    const Vec3 kExtent(15.0, 15.0, 9.0);

    double volume(const TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += tet_volume(mesh, t);
        return sum;
    }

    std::array<VertexId, 3> sorted_face(const CutSession& session, const TetFace& face)
    {
        const auto nodes = session.tet(face.tet).nodes;
        std::array<VertexId, 3> key {};
        for (std::size_t i = 0; i < 3; ++i)
            key[i] = nodes[static_cast<std::size_t>(kTetFaces[static_cast<std::size_t>(face.corner)][i])];
        std::sort(key.begin(), key.end());
        return key;
    }

    /// A closed surface, two faces at each edge; every lip on it; pinched vertices as said; nothing unused.
    void expect_sound(const CutSession& session)
    {
        SlotMap map;
        const TetMesh mesh = session.compact_mesh(&map);
        ASSERT_NO_THROW(check_mesh(mesh));
        std::map<std::pair<VertexId, VertexId>, int> edges;
        std::set<std::pair<TetId, int>> boundary;
        for (const TetFace& face : boundary_faces(mesh)) {
            boundary.emplace(map.tet_slot[static_cast<std::size_t>(face.tet)], face.corner);
            const auto v = face_vertices(mesh, face);
            for (std::size_t i = 0; i < 3; ++i)
                ++edges[std::minmax(v[i], v[(i + 1) % 3])];
        }
        for (const auto& [edge, count] : edges)
            ASSERT_EQ(count, 2) << edge.first << " - " << edge.second;
        for (const LipFace& lip : session.lips())
            EXPECT_TRUE(boundary.contains({ lip.face.tet, lip.face.corner }));
        const std::set<VertexId> used(mesh.nodes.begin(), mesh.nodes.end());
        EXPECT_EQ(used.size(), mesh.vertex_count());
    }

    TEST(Ablation, RemovesOneElementAndBaresItsNeighbours)
    {
        CutSession session(kuhn_box(3, 3, 3, 1.0));
        // An element all of whose neighbours exist.
        TetId inner = -1;
        for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()) && inner < 0; ++t) {
            bool inside = true;
            for (const VertexId v : session.tet(t).nodes)
                inside = inside && session.position(v).minCoeff() > 0.5 && session.position(v).maxCoeff() < 2.5;
            inner = inside ? t : inner;
        }
        ASSERT_GE(inner, 0);
        const CutResult result = session.ablate(std::vector<TetId> { inner, inner });
        ASSERT_EQ(result.status, CutStatus::done);
        EXPECT_NEAR(result.report.removed_volume_mm3, 1.0 / 6.0, kRoundOff);
        // A Kuhn tetrahedron has two faces of area 1/2 and two of sqrt(2)/2.
        EXPECT_NEAR(result.report.lip_area_mm2, 1.0 + std::sqrt(2.0), kRoundOff);
        EXPECT_EQ(result.delta.tets_gone.size(), 1u);
        EXPECT_TRUE(result.delta.vertices_gone.empty());
        ASSERT_EQ(session.lips().size(), 4u);
        for (const LipFace& lip : session.lips()) {
            EXPECT_EQ(lip.side, 0);
            EXPECT_EQ(lip.cut, 0);
        }
        expect_sound(session);
    }

    TEST(Ablation, KeepsTheSurfaceManifoldAndIsTakenBackToTheLastBit)
    {
        std::mt19937 random(3);
        std::size_t done = 0, gone = 0, parted = 0;
        for (int patient = 0; patient < 30; ++patient) {
            CutSession session(test_support::three_layers(5, 5, 3, 3.0));
            const double whole = volume(session.compact_mesh());
            double removed = 0.0;
            std::vector<test_support::SessionState> states { test_support::SessionState(session) };
            for (int i = 0; i < 4; ++i) {
                std::vector<TetId> marked = test_support::random_marks(random, session, kExtent, 3.0);
                if (i % 2 == 1) { // crumbs: every third element, which leaves edges and points
                    std::vector<TetId> some;
                    for (std::size_t k = 0; k < marked.size(); k += 3)
                        some.push_back(marked[k]);
                    marked = some;
                }
                if (marked.empty())
                    continue;
                const CutResult result = session.ablate(marked);
                ASSERT_EQ(result.status, CutStatus::done);
                ++done;
                gone += result.delta.vertices_gone.size();
                parted += result.delta.vertices_born.size();
                removed += result.report.removed_volume_mm3;
                SCOPED_TRACE("patient " + std::to_string(patient) + " ablation " + std::to_string(i));
                expect_sound(session);
                if (HasFatalFailure())
                    return;
                EXPECT_NEAR(volume(session.compact_mesh()) + removed, whole, kRoundOff * whole);
                states.emplace_back(session);
            }
            while (states.size() > 1) {
                states.pop_back();
                const MeshDelta back = session.undo();
                ASSERT_TRUE(states.back().mesh.nodes == test_support::SessionState(session).mesh.nodes);
                EXPECT_TRUE((states.back().mesh.vertices.array() == session.compact_mesh().vertices.array()).all());
            }
            while (session.can_redo())
                static_cast<void>(session.redo());
            EXPECT_NEAR(volume(session.compact_mesh()) + removed, whole, kRoundOff * whole);
            expect_sound(session);
        }
        EXPECT_GT(done, 100u);
        EXPECT_GT(gone, 30u); // vertices died
        EXPECT_GT(parted, 50u); // and edges and points were parted
    }

    TEST(Ablation, OfASeveredWedge)
    {
        // Two blades that meet along a line 5 mm deep, 2 x 4 mm apart at the top, through the whole box.
        const double depth = 5.0, half = 4.0, length = 15.0;
        CutSession session(test_support::three_layers(5, 5, 3, 3.0));
        const Vec3 bottom(0.0, 7.3, 9.0 - depth);
        for (const double side : { -1.0, 1.0 }) {
            const Vec3 d = Vec3(0.0, -side * half, -depth).normalized();
            const Vec3 top = bottom - d * std::hypot(half, depth);
            const Blade blade { .line = { top + Vec3(-1, 0, 0), top + Vec3(length + 1, 0, 0) },
                .directions = { d },
                .depth_mm = std::hypot(half, depth) };
            ASSERT_EQ(session.cut(blade, { .snap = 0.0 }).status, CutStatus::done);
        }
        const std::vector<Piece> pieces = find_pieces(session);
        ASSERT_EQ(pieces.size(), 2u);
        EXPECT_NEAR(pieces[1].volume_mm3, half * depth * length, 1e-9);
        // The centroid of a triangle: a third of its height from its base.
        EXPECT_NEAR((pieces[1].centroid - Vec3(7.5, 7.3, 9.0 - depth / 3.0)).norm(), 0.0, 1e-9);
        ASSERT_EQ(pieces[1].labels.size(), 2u);
        EXPECT_EQ(pieces[1].labels[0].first, 3);
        const CutResult result = session.ablate(pieces[1].tets);
        ASSERT_EQ(result.status, CutStatus::done);
        EXPECT_NEAR(result.report.removed_volume_mm3, half * depth * length, 1e-9);
        EXPECT_EQ(find_pieces(session).size(), 1u);
        expect_sound(session);
    }

    TEST(Ablation, OfARibSegmentBetweenTwoBlades)
    {
        // A bar of label 7 along x, 3 x 3 mm; 6 mm of it between two blades that sever nothing else.
        TetMesh box = kuhn_box(8, 5, 3, 3.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            Vec3 c = Vec3::Zero();
            for (const VertexId v : box.tet(t))
                c += 0.25 * box.vertices.row(v).transpose();
            if (c.y() > 6 && c.y() < 9 && c.z() > 3 && c.z() < 6)
                box.labels[static_cast<std::size_t>(t)] = 7;
        }
        CutSession session(box);
        const auto saw = [](double x) {
            return Blade { .line = { { x, -1, 9 }, { x, 16, 9 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 12.0 };
        };
        for (const double x : { 8.3, 14.3 })
            ASSERT_EQ(session.cut(saw(x), { .snap = 0.0, .uncut_labels = { 1 } }).status, CutStatus::done);
        EXPECT_EQ(find_pieces(session).size(), 1u);
        const Eigen::AlignedBox3d between(Vec3(8.3, 6.0, 3.0), Vec3(14.3, 9.0, 6.0));
        const std::vector<TetId> marked = test_support::elements_in(session, between);
        const CutResult result = session.ablate(marked);
        ASSERT_EQ(result.status, CutStatus::done);
        EXPECT_NEAR(result.report.removed_volume_mm3, 6.0 * 3.0 * 3.0, 1e-9);
        expect_sound(session);
        for (const MeshDelta::Tet& tet : result.delta.tets_gone)
            if (std::find(marked.begin(), marked.end(), tet.id) != marked.end()) {
                EXPECT_EQ(tet.label, 7);
            }
    }

    TEST(Ablation, BaredFacesAreFaceToFaceWithWhatWent)
    {
        CutSession session(test_support::three_layers(5, 5, 3, 3.0));
        const Eigen::AlignedBox3d box(Vec3(2.5, 2.5, 2.5), Vec3(9.5, 9.5, 9.5));
        const std::vector<TetId> marked = test_support::elements_in(session, box);
        std::map<std::array<VertexId, 3>, int> faces;
        for (const TetId t : marked)
            for (int corner = 0; corner < 4; ++corner)
                ++faces[sorted_face(session, { t, corner })];
        std::set<std::array<VertexId, 3>> bared;
        for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t)
            for (int corner = 0; corner < 4; ++corner)
                if (const auto key = sorted_face(session, { t, corner });
                    !std::binary_search(marked.begin(), marked.end(), t) && faces.contains(key))
                    bared.insert(key);
        ASSERT_EQ(session.ablate(marked).status, CutStatus::done);
        std::set<std::array<VertexId, 3>> lips;
        for (const LipFace& lip : session.lips())
            lips.insert(sorted_face(session, lip.face));
        EXPECT_EQ(lips, bared);
        // Five of a cube's faces lie within the body: two by two squares each, of two triangles.
        EXPECT_EQ(lips.size(), 5u * 4u * 2u);
    }

    TEST(Ablation, WrongMarksAreRefused)
    {
        CutSession session(kuhn_box(2, 2, 2, 1.0));
        const test_support::SessionState before(session);
        const auto refused = [&](const std::vector<TetId>& tets, const std::string& what) {
            try {
                static_cast<void>(session.ablate(tets));
                FAIL() << "accepted: " << what;
            } catch (const InputError& error) {
                EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
            }
        };
        refused({}, "nothing is marked");
        refused({ 0, 48 }, "no such element");
        refused({ -1 }, "no such element");
        std::vector<TetId> all;
        for (TetId t = 0; t < 48; ++t)
            all.push_back(t);
        refused(all, "everything is marked");
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(static_cast<void>(mark_ball(session, Vec3(nan, 0, 0), 1.0)), InputError);
        EXPECT_THROW(static_cast<void>(mark_ball(session, Vec3(0, 0, 0), nan)), InputError);
        EXPECT_THROW(static_cast<void>(mark_ball(session, Vec3(0, 0, 0), 0.0)), InputError);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(session.ablate(std::vector<TetId> { 3 }, job).status, CutStatus::cancelled);
        EXPECT_TRUE(test_support::SessionState(session) == before);
        ASSERT_TRUE(
            session
                .extend_stroke(
                    { .line = { { 0.3, 1.1, 2 }, { 1.7, 0.9, 2 } }, .directions = { { 0, 0, -1 } }, .depth_mm = 1.2 })
                .status
            == CutStatus::done);
        refused({ 3 }, "stroke is open");
    }

} // namespace cut_ablation_test
} // namespace retractor::mesh
