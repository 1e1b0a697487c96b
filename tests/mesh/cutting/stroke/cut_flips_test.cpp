// Flips: closed forms on hand-made elements, what they must not touch, and that they take nothing from a mesh.

#include "mesh/cutting/stroke/cut_flips.h"
#include "mesh/cutting/stroke/cut_moves.h"
#include "tests/support/session_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace retractor::mesh {
namespace cut_flips_test {

    constexpr double kRoundOff = 1e-13; // relative, of a few additions
    constexpr double kMeshRoundOff = 1e-12; // the same for sums over some hundred elements

    struct Tets {
        std::vector<Vec3> points;
        std::vector<std::array<VertexId, 4>> nodes;
        std::vector<Label> labels;
    };

    TetMesh as_mesh(const Tets& tets)
    {
        TetMesh mesh;
        mesh.vertices.resize(static_cast<Eigen::Index>(tets.points.size()), 3);
        for (std::size_t v = 0; v < tets.points.size(); ++v)
            mesh.vertices.row(static_cast<Eigen::Index>(v)) = tets.points[v].transpose();
        for (std::size_t t = 0; t < tets.nodes.size(); ++t) {
            mesh.nodes.insert(mesh.nodes.end(), tets.nodes[t].begin(), tets.nodes[t].end());
            mesh.labels.push_back(tets.labels.empty() ? Label { 1 } : tets.labels[t]);
        }
        return mesh;
    }

    /// Vertices 0 to 2 are an equilateral triangle round the z axis with corners at distance 1; 3 lies above, 4 below.
    std::vector<Vec3> bipyramid(double above, double below)
    {
        const double s = std::sqrt(3.0) / 2.0;
        return { { 1, 0, 0 }, { -0.5, s, 0 }, { -0.5, -s, 0 }, { 0, 0, above }, { 0, 0, -below } };
    }
    const double kTriangle = 3.0 * std::sqrt(3.0) / 4.0; // its area

    Tets two(double above, double below) { return { bipyramid(above, below), { { 0, 1, 2, 3 }, { 0, 2, 1, 4 } }, {} }; }

    Tets three(double above, double below)
    {
        return { bipyramid(above, below), { { 4, 0, 1, 3 }, { 4, 1, 2, 3 }, { 4, 2, 0, 3 } }, {} };
    }

    /// Four elements round the axis 4-5 of an octahedron with these half axes.
    Tets octahedron(double x, double y, double z)
    {
        return { { { x, 0, 0 }, { 0, y, 0 }, { -x, 0, 0 }, { 0, -y, 0 }, { 0, 0, -z }, { 0, 0, z } },
            { { 4, 0, 1, 5 }, { 4, 1, 2, 5 }, { 4, 2, 3, 5 }, { 4, 3, 0, 5 } }, {} };
    }

    std::set<std::set<VertexId>> elements(const CutStore& store)
    {
        std::set<std::set<VertexId>> all;
        for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
            if (store.has_tet(t))
                all.emplace(store.tet(t).nodes.begin(), store.tet(t).nodes.end());
        return all;
    }

    double angle(double cosine) { return std::acos(cosine); }

    TEST(Flips, ThreeForTwoByTheClosedForm)
    {
        CutStore store(as_mesh(two(0.4, 0.5)));
        const auto flip = face_flip(store, 0, 3);
        ASSERT_TRUE(flip.has_value());
        EXPECT_EQ(flip->gone, (std::vector<TetId> { 0, 1 }));
        EXPECT_EQ(flip->faces_gone, (std::vector<FaceKey> { { 0, 1, 2 } }));
        EXPECT_EQ(flip->faces_born.size(), 3u);
        // Before, an apex at height h over an equilateral triangle with inradius 1/2: tan = h / (1/2) at its edges.
        EXPECT_NEAR(angle(flip->cosine_before), std::atan2(0.4, 0.5), 1e-12);
        // After, 120 degrees about the axis, and at each edge of the triangle the sum of both: the smallest is between
        // the axis planes and the outer faces.
        EXPECT_LT(flip->cosine_after, 1.0);
        store.begin();
        const std::vector<TetId> born = make_flip(store, *flip);
        static_cast<void>(store.finish());
        ASSERT_EQ(born.size(), 3u);
        for (const TetId t : born) {
            EXPECT_NEAR(store.volume(t), kTriangle / 3.0 * 0.9 / 3.0, kRoundOff);
            EXPECT_GE(store.corner(t, 3), 0);
            EXPECT_GE(store.corner(t, 4), 0);
            EXPECT_NEAR(
                smallest_dihedral_cosine(corners_of(store, t)), flip->cosine_after, kRoundOff); // all three alike
        }
        EXPECT_EQ(elements(store), elements(CutStore(as_mesh(three(0.4, 0.5)))));
    }

    TEST(Flips, TwoForThreeAndBackAgain)
    {
        CutStore store(as_mesh(three(0.4, 0.5)));
        const auto flip = edge_flip(store, { 3, 4 });
        ASSERT_TRUE(flip.has_value());
        EXPECT_EQ(flip->gone.size(), 3u);
        EXPECT_EQ(flip->faces_born, (std::vector<FaceKey> { { 0, 1, 2 } }));
        EXPECT_EQ(flip->edges_gone, (std::vector<EdgeKey> { { 3, 4 } }));
        EXPECT_NEAR(angle(flip->cosine_after), std::atan2(0.4, 0.5), 1e-12);
        store.begin();
        const std::vector<TetId> born = make_flip(store, *flip);
        static_cast<void>(store.finish());
        EXPECT_EQ(elements(store), elements(CutStore(as_mesh(two(0.4, 0.5)))));
        double volume = 0.0;
        for (const TetId t : born)
            volume += store.volume(t);
        EXPECT_NEAR(volume, kTriangle / 3.0 * 0.9, kRoundOff);
        int corner = 0;
        while (store.tet(born[0]).nodes[static_cast<std::size_t>(corner)] < 3)
            ++corner;
        const auto back = face_flip(store, born[0], corner);
        ASSERT_TRUE(back.has_value());
        EXPECT_EQ(back->cosine_after, flip->cosine_before);
        store.begin();
        make_flip(store, *back);
        static_cast<void>(store.finish());
        EXPECT_EQ(elements(store), elements(CutStore(as_mesh(three(0.4, 0.5)))));
    }

    TEST(Flips, AnOctahedronTurnsToItsShortestAxis)
    {
        CutStore store(as_mesh(octahedron(1.0, 1.5, 4.0)));
        const auto flip = edge_flip(store, { 4, 5 });
        ASSERT_TRUE(flip.has_value());
        EXPECT_LT(flip->cosine_after, flip->cosine_before);
        store.begin();
        const std::vector<TetId> born = make_flip(store, *flip);
        static_cast<void>(store.finish());
        ASSERT_EQ(born.size(), 4u);
        for (const TetId t : born) {
            EXPECT_NEAR(store.volume(t), 1.0 * 1.5 * 4.0 / 3.0, 10.0 * kRoundOff);
            EXPECT_GE(store.corner(t, 0), 0) << "the shortest axis joins 0 and 2";
            EXPECT_GE(store.corner(t, 2), 0);
        }
        EXPECT_EQ(flip->faces_born.size(), 4u); // round the new axis
    }

    TEST(Flips, RefuseSurfacesInterfacesAndWhatWouldTurnOver)
    {
        const CutStore plain(as_mesh(two(0.4, 0.5)));
        for (int corner = 0; corner < 3; ++corner)
            EXPECT_FALSE(face_flip(plain, 0, corner).has_value()) << "a face of the surface";
        EXPECT_FALSE(edge_flip(plain, { 0, 1 }).has_value()) << "an edge of the surface";
        Tets labelled = two(0.4, 0.5);
        labelled.labels = { 1, 2 };
        EXPECT_FALSE(face_flip(CutStore(as_mesh(labelled)), 0, 3).has_value()) << "a face between two labels";
        labelled = three(0.4, 0.5);
        labelled.labels = { 1, 1, 2 };
        EXPECT_FALSE(edge_flip(CutStore(as_mesh(labelled)), { 3, 4 }).has_value()) << "an edge between two labels";
        Tets leaning = two(0.4, 0.5);
        leaning.points[3] = { 3.0, 0.0, 0.4 };
        leaning.points[4] = { 3.0, 0.0, -0.5 };
        EXPECT_FALSE(face_flip(CutStore(as_mesh(leaning)), 0, 3).has_value()) << "the new edge passes by";
        Tets hollow = three(0.4, 0.5);
        hollow.points[3].z() = -0.2; // both ends of the edge below the triangle
        EXPECT_FALSE(edge_flip(CutStore(as_mesh(hollow)), { 3, 4 }).has_value()) << "one element would turn over";
        Tets flat = two(0.4, 0.5);
        flat.points[3] = Vec3(0.25, std::sqrt(3.0) / 4.0, 0.4); // over the middle of an edge
        flat.points[4] = Vec3(0.25, std::sqrt(3.0) / 4.0, -0.5);
        EXPECT_FALSE(face_flip(CutStore(as_mesh(flat)), 0, 3).has_value()) << "an element would have no volume";
    }

    TEST(Flips, RefuseAnEdgeThatIsThereAlready)
    {
        // The apices are joined behind the bipyramid, through vertex 5.
        Tets tets = two(0.4, 0.5);
        tets.points.push_back({ 4, 0.1, 0 });
        tets.points.push_back({ 4, 3.0, 0 });
        tets.nodes.push_back({ 4, 5, 6, 3 });
        TetMesh mesh = as_mesh(tets);
        ASSERT_GT(tet_volume(mesh, 2), 0.0);
        EXPECT_FALSE(face_flip(CutStore(mesh), 0, 3).has_value());
    }

    TEST(Flips, OriginsAreThoseWithTheMostVolume)
    {
        const auto origins = [](const Tets& tets, bool face) {
            CutStore store(as_mesh(tets));
            const auto flip = face ? face_flip(store, 0, 3) : edge_flip(store, { 3, 4 });
            store.begin();
            std::set<TetId> all;
            for (const TetId t : make_flip(store, flip.value()))
                all.insert(store.tet(t).origin);
            static_cast<void>(store.finish());
            return all;
        };
        EXPECT_EQ(origins(two(0.3, 0.6), true), (std::set<TetId> { 1 }));
        EXPECT_EQ(origins(two(0.6, 0.3), true), (std::set<TetId> { 0 }));
        Tets shifted = three(0.4, 0.5);
        for (const VertexId v : { 3, 4 })
            shifted.points[static_cast<std::size_t>(v)].x() = -0.1; // away from corner 0: the element 1 2 is smallest
        shifted.points[3].y() = shifted.points[4].y() = -0.05; // and that of 0 and 1 the largest
        EXPECT_EQ(origins(shifted, false), (std::set<TetId> { 0 }));
    }

    TEST(Flips, SharedVolumeByTheClosedForm)
    {
        const std::array<Vec3, 4> unit { Vec3 { 0, 0, 0 }, Vec3 { 1, 0, 0 }, Vec3 { 0, 1, 0 }, Vec3 { 0, 0, 1 } };
        EXPECT_NEAR(shared_volume(unit, unit), 1.0 / 6.0, kRoundOff);
        std::array<Vec3, 4> moved = unit;
        for (Vec3& p : moved)
            p.x() += 0.5;
        EXPECT_NEAR(shared_volume(unit, moved), 1.0 / 48.0, kRoundOff) << "similar, half as large";
        EXPECT_NEAR(shared_volume(moved, unit), 1.0 / 48.0, kRoundOff);
        for (Vec3& p : moved)
            p.x() += 1.0;
        EXPECT_EQ(shared_volume(unit, moved), 0.0);
        std::array<Vec3, 4> small = unit; // within: 1/4 of the size
        for (Vec3& p : small)
            p = Vec3(0.1, 0.1, 0.1) + 0.25 * p;
        EXPECT_NEAR(shared_volume(unit, small), 1.0 / 6.0 / 64.0, kRoundOff);
        EXPECT_NEAR(shared_volume(small, unit), 1.0 / 6.0 / 64.0, kRoundOff);
    }

    TEST(Flips, LipsStayWhereTheyAreAndUndoIsExact)
    {
        CutStore store(as_mesh(two(0.4, 0.5)));
        store.begin();
        store.set_lips(0, { LipTag { 3, 1 }, {}, {}, {} });
        store.set_lips(1, { LipTag {}, { 5, -1 }, {}, {} });
        static_cast<void>(store.finish());
        const auto tags = [&] {
            std::map<FaceKey, std::pair<int, int>> all;
            for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
                for (int corner = 0; store.has_tet(t) && corner < 4; ++corner)
                    if (const LipTag tag = store.tet(t).lips[static_cast<std::size_t>(corner)]; tag.cut >= 0)
                        all[face_key(store.tet(t), corner)] = { tag.cut, tag.side };
            return all;
        };
        const auto before = tags();
        ASSERT_EQ(before.size(), 2u);
        const auto slots = [&] {
            std::vector<std::pair<std::array<VertexId, 4>, TetId>> all;
            for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
                if (store.has_tet(t))
                    all.emplace_back(store.tet(t).nodes, store.tet(t).origin);
            return all;
        };
        const auto first = slots();
        const auto flip = face_flip(store, 0, 3);
        ASSERT_TRUE(flip.has_value());
        store.begin();
        make_flip(store, *flip);
        const CutRecord record = store.finish();
        EXPECT_EQ(record.delta.tets_gone.size(), 2u);
        EXPECT_EQ(record.delta.tets_born.size(), 3u);
        EXPECT_TRUE(record.delta.vertices_born.empty() && record.delta.vertices_moved.empty());
        EXPECT_EQ(tags(), before);
        const auto last = slots();
        store.undo(record);
        EXPECT_EQ(slots(), first);
        EXPECT_EQ(tags(), before);
        store.redo(record);
        EXPECT_EQ(slots(), last);
        EXPECT_EQ(tags(), before);
    }

    TEST(Flips, TakeNothingFromAMeshAndItsWorstAngleNeverFalls)
    {
        TetMesh mesh = test_support::three_layers(5, 5, 6, 2.0);
        std::mt19937 random(5);
        const Eigen::RowVector3d top = mesh.vertices.colwise().maxCoeff();
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            for (int axis = 0; axis < 2; ++axis) // layers stay flat
                if (mesh.vertices(v, 0) > 0.0 && mesh.vertices(v, 0) < top[0] && mesh.vertices(v, 1) > 0.0
                    && mesh.vertices(v, 1) < top[1])
                    mesh.vertices(v, axis) += 0.8 * (std::generate_canonical<double, 53>(random) - 0.5);
        check_mesh(mesh);
        CutStore store(mesh);
        const auto volumes = [&] {
            std::map<Label, double> sum;
            for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
                if (store.has_tet(t))
                    sum[store.tet(t).label] += store.volume(t);
            return sum;
        };
        const auto surface_and_interfaces = [&] {
            std::map<FaceKey, std::vector<Label>> faces;
            for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
                for (int corner = 0; store.has_tet(t) && corner < 4; ++corner)
                    faces[face_key(store.tet(t), corner)].push_back(store.tet(t).label);
            std::map<FaceKey, std::set<Label>> held;
            for (const auto& [key, labels] : faces) {
                EXPECT_LE(labels.size(), 2u);
                if (labels.size() == 1 || labels[0] != labels[1])
                    held[key] = { labels.begin(), labels.end() };
            }
            return held;
        };
        const auto worst = [&] {
            double largest = -1.0;
            for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots); ++t)
                if (store.has_tet(t))
                    largest = std::max(largest, smallest_dihedral_cosine(corners_of(store, t)));
            return largest;
        };
        const auto volumes_before = volumes();
        const auto held_before = surface_and_interfaces();
        std::size_t faces = 0, edges = 0;
        store.begin();
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); t += 7) // any at all, for the mesh to be spoilt
            for (int corner = 0; store.has_tet(t) && corner < 4; ++corner)
                if (const auto flip = face_flip(store, t, corner)) {
                    make_flip(store, *flip);
                    ++faces;
                }
        EXPECT_EQ(surface_and_interfaces(), held_before);
        double before = worst();
        for (TetId t = 0; t < static_cast<TetId>(store.counts().tet_slots) && edges < 400; ++t) {
            for (int corner = 0; store.has_tet(t) && corner < 4; ++corner)
                if (const auto flip = face_flip(store, t, corner);
                    flip && flip->cosine_after < flip->cosine_before - 1e-6) {
                    make_flip(store, *flip);
                    ++faces;
                }
            for (const auto& e : kTetEdges)
                if (store.has_tet(t)) {
                    const auto nodes = store.tet(t).nodes;
                    const auto flip = edge_flip(store,
                        std::minmax(nodes[static_cast<std::size_t>(e[0])], nodes[static_cast<std::size_t>(e[1])]));
                    if (flip && flip->cosine_after < flip->cosine_before - 1e-6) {
                        double claimed = -1.0;
                        for (const TetId born : make_flip(store, *flip))
                            claimed = std::max(claimed, smallest_dihedral_cosine(corners_of(store, born)));
                        EXPECT_NEAR(claimed, flip->cosine_after, kRoundOff);
                        ++edges;
                    }
                }
            const double now = worst();
            ASSERT_LE(now, before);
            before = now;
        }
        static_cast<void>(store.finish());
        EXPECT_GT(faces, 20u);
        EXPECT_GT(edges, 20u);
        for (const auto& [label, volume] : volumes())
            EXPECT_NEAR(volume, volumes_before.at(label), kMeshRoundOff * volume);
        EXPECT_EQ(surface_and_interfaces(), held_before);
        const auto tets = elements(store);
        EXPECT_EQ(tets.size(), store.counts().tets) << "no element twice";
    }

} // namespace cut_flips_test
} // namespace retractor::mesh
