#include "fem/interactive/online_stiffness.h"

#include "fem/model/pre_strain.h"

#include "fem/model/elastic_body.h"
#include "mesh/base/error.h"
#include "tests/support/random_strokes.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace retractor::fem {
namespace online_stiffness_test {

    using namespace test_support;

    const std::vector<Material> kTissues { test_support::material(1.0, 0.3), test_support::material(0.02, 0.45),
        test_support::material(2.0, 0.3) };

    mesh::TetMesh layered_box()
    {
        mesh::TetMesh box = mesh::kuhn_box(8, 8, 4, 4.0);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t)
            box.labels[static_cast<std::size_t>(t)] = box.vertices(box.tet(t)[0], 2) >= 8.0 ? 2 : 1;
        return box;
    }
    const Vec3 kBoxSize(32.0, 32.0, 16.0);

    /// In the upper layer.
    std::vector<Mat3> tension()
    {
        Mat3 skin = Mat3::Zero();
        skin(0, 0) = 0.01;
        skin(0, 1) = skin(1, 0) = 0.002;
        std::vector<Mat3> of_element;
        for (const Label label : layered_box().labels)
            of_element.push_back(label == 2 ? skin : Mat3(Mat3::Zero()));
        return of_element;
    }

    void expect_same_bits(const OnlineStiffness& followed, const OnlineStiffness& fresh)
    {
        ASSERT_EQ(followed.vertex_count(), fresh.vertex_count());
        ASSERT_EQ(followed.tet_count(), fresh.tet_count());
        const std::size_t slots = std::max(followed.slot_count(), fresh.slot_count());
        for (VertexId v = 0; v < static_cast<VertexId>(slots); ++v) {
            static const OnlineStiffness::Row kNone;
            const bool in_followed = v < static_cast<VertexId>(followed.slot_count());
            const bool in_fresh = v < static_cast<VertexId>(fresh.slot_count());
            ASSERT_EQ(in_followed ? followed.row(v) : kNone, in_fresh ? fresh.row(v) : kNone) << "vertex " << v;
            if (in_followed && in_fresh) {
                ASSERT_EQ(Vec3(followed.load().segment<3>(3 * v)), Vec3(fresh.load().segment<3>(3 * v)));
            }
        }
    }

    TEST(OnlineStiffness, EqualsTheStiffnessOfTheBody)
    {
        const mesh::TetMesh box = verification::distorted_box(4, 2.0, 0.2, 7);
        const Material tissue = test_support::material(0.02, 0.45);
        const OnlineStiffness online(mesh::CutSession(box), std::vector<Material> { tissue, tissue });
        ElasticBody body(box, Elasticity::linear, test_support::uniform(box, tissue));
        const Eigen::VectorXd x = verification::nodal_values(
            box, [](const Vec3& p) { return Vec3(std::sin(p.x()), p.y() * p.z(), std::cos(p.y())); });
        const Eigen::VectorXd expected = body.stiffness(Eigen::VectorXd::Zero(x.size()), 0.0).multiply(x);
        constexpr double kRoundOff = 1e-13;
        EXPECT_LT((online.multiply(x) - expected).norm(), kRoundOff * expected.norm());
        Eigen::MatrixXd cases(x.size(), 2);
        cases << x, -2.0 * x;
        EXPECT_LT((online.multiply(cases).col(1) + 2.0 * expected).norm(), kRoundOff * expected.norm());
    }

    TEST(OnlineStiffness, HasTheBitsOfAFreshAssemblyAfterCutsUndosAndRedos)
    {
        for (unsigned seed = 1; seed <= 4; ++seed) {
            mesh::CutSession session(layered_box());
            OnlineStiffness followed(session, kTissues, tension());
            std::mt19937 random(seed);
            for (int i = 0; i < 10; ++i) {
                test_support::random_change(session, random, kBoxSize, [&](const mesh::MeshDelta& delta) {
                    followed.apply(delta);
                    followed.set_wound(session.lips());
                });
                ASSERT_NO_FATAL_FAILURE(expect_same_bits(followed, OnlineStiffness(session, kTissues, tension())))
                    << "seed " << seed << ", change " << i;
            }
        }
    }

    TEST(OnlineStiffness, ABedGoesAndComesBackWithItsVertexAndNotWithItsId)
    {
        const mesh::TetMesh box = layered_box();
        mesh::CutSession session(box);
        const auto is_first = [&](VertexId v) { // in its place, and not another under its id
            return session.has_vertex(v) && session.position(v) == Vec3(box.vertices.row(v).transpose());
        };
        const auto beds = [&] {
            std::vector<double> bed(session.vertex_slots(), 0.0);
            for (VertexId v = 0; v < static_cast<VertexId>(box.vertex_count()); ++v)
                if (box.vertices(v, 2) == 0.0 && is_first(v))
                    bed[static_cast<std::size_t>(v)] = 0.1 + 0.01 * v;
            return bed;
        };
        OnlineStiffness followed(session, kTissues);
        followed.set_bed(beds());
        const auto expect_right = [&] {
            OnlineStiffness fresh(session, kTissues);
            fresh.set_bed(beds());
            expect_same_bits(followed, fresh);
        };
        std::vector<TetId> marked;
        for (VertexId v = 0; v < static_cast<VertexId>(box.vertex_count()); ++v)
            if (box.vertices(v, 2) == 0.0 && box.vertices(v, 0) < 6.0 && box.vertices(v, 1) < 6.0)
                for (const TetId t : session.tets_at(v))
                    marked.push_back(t);
        const mesh::CutResult ablation = session.ablate(marked);
        ASSERT_EQ(ablation.status, mesh::CutStatus::done);
        ASSERT_GE(ablation.delta.vertices_gone.size(), 4U);
        followed.apply(ablation.delta);
        expect_right();
        const mesh::CutResult cut = session.cut(
            { .line = { { 10, 15.2, 16 }, { 33, 16.1, 16 } }, .directions = { { 0.02, 0.05, -1.0 } }, .depth_mm = 7.0 },
            { .snap = 0.0 });
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        for (const auto& gone : ablation.delta.vertices_gone) {
            ASSERT_TRUE(session.has_vertex(gone.id)); // used again
            EXPECT_FALSE(is_first(gone.id));
        }
        followed.apply(cut.delta);
        expect_right();
        for (int times = 0; times < 2; ++times) {
            followed.apply(session.undo());
            expect_right();
            followed.apply(session.undo());
            expect_right();
            for (const auto& gone : ablation.delta.vertices_gone)
                EXPECT_EQ(followed.bed(gone.id), box.vertices(gone.id, 2) == 0.0 ? 0.1 + 0.01 * gone.id : 0.0);
            followed.apply(session.redo());
            expect_right();
            followed.apply(session.redo());
            expect_right();
        }
    }

    TEST(OnlineStiffness, ChangesOnlyTheRowsItNames)
    {
        mesh::CutSession session(layered_box());
        OnlineStiffness followed(session, kTissues);
        const OnlineStiffness before = followed;
        std::mt19937 random(3);
        const mesh::CutResult cut = session.cut(test_support::random_blade(random, kBoxSize));
        ASSERT_EQ(cut.status, mesh::CutStatus::done);
        const std::vector<VertexId> touched = followed.touched_by(cut.delta);
        EXPECT_LT(touched.size(), before.vertex_count());
        followed.apply(cut.delta);
        for (VertexId v = 0; v < static_cast<VertexId>(before.slot_count()); ++v)
            if (!std::binary_search(touched.begin(), touched.end(), v)) {
                EXPECT_EQ(followed.row(v), before.row(v)) << "vertex " << v;
            }
    }

    TEST(OnlineStiffness, IsSymmetricToTheBitAndKeepsRigidMotionsFree)
    {
        mesh::CutSession session(layered_box());
        OnlineStiffness followed(session, kTissues);
        std::mt19937 random(5);
        test_support::random_change(
            session, random, kBoxSize, [&](const mesh::MeshDelta& delta) { followed.apply(delta); });
        for (VertexId v = 0; v < static_cast<VertexId>(followed.slot_count()); ++v) {
            const OnlineStiffness::Row& row = followed.row(v);
            for (std::size_t i = 0; i < row.column.size(); ++i) {
                const OnlineStiffness::Row& other = followed.row(row.column[i]);
                const auto back = std::lower_bound(other.column.begin(), other.column.end(), v) - other.column.begin();
                for (std::size_t a = 0; a < 3; ++a)
                    for (std::size_t b = 0; b < 3; ++b)
                        ASSERT_EQ(
                            row.value[9 * i + 3 * a + b], other.value[9 * static_cast<std::size_t>(back) + 3 * b + a]);
            }
        }
        Eigen::VectorXd turned(3 * static_cast<Eigen::Index>(followed.slot_count()));
        for (VertexId v = 0; v < static_cast<VertexId>(followed.slot_count()); ++v)
            turned.segment<3>(3 * v) = Vec3(0.3, -0.1, 0.7).cross(followed.position(v)) + Vec3(1.0, 2.0, 3.0);
        constexpr double kRoundOff = 1e-11; // N; entries of about 10 N/mm times 30 mm
        EXPECT_LT(followed.multiply(turned).lpNorm<Eigen::Infinity>(), kRoundOff);
    }

    /// By session ids.
    Eigen::VectorXd released(const mesh::CutSession& session, const std::vector<Mat3>& stress_of_origin)
    {
        mesh::SlotMap map;
        const mesh::TetMesh mesh = session.compact_mesh(&map);
        std::vector<mesh::TetFace> faces;
        for (const mesh::LipFace& lip : session.lips())
            faces.push_back({ map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
        std::vector<Mat3> stresses;
        for (const TetId slot : map.tet_slot)
            stresses.push_back(stress_of_origin[static_cast<std::size_t>(session.origin(slot))]);
        const Eigen::VectorXd loads = traction_loads(mesh, released_tractions(mesh, faces, stresses));
        Eigen::VectorXd by_id = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(map.compact_vertex.size()));
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
            by_id.segment<3>(3 * map.vertex_slot[v]) = loads.segment<3>(3 * static_cast<Eigen::Index>(v));
        return by_id;
    }

    TEST(OnlineStiffness, WoundsSetTheTensionFreeThatWasThere)
    {
        const Vec3 box(32.0, 32.0, 16.0);
        mesh::CutSession session(mesh::kuhn_box(8, 8, 4, 4.0));
        const mesh::TetMesh first = session.compact_mesh();
        std::vector<Mat3> tension;
        for (std::size_t t = 0; t < first.tet_count(); ++t) {
            Mat3 s = Mat3::Identity() * (0.001 * static_cast<double>(t % 7));
            s(0, 1) = s(1, 0) = 0.002;
            tension.push_back(s);
        }
        const std::vector<Material> tissue { test_support::material(1.0, 0.3), test_support::material(1.0, 0.3) };
        OnlineStiffness online(session, tissue, tension);
        EXPECT_EQ(online.load().lpNorm<Eigen::Infinity>(), 0.0) << "nothing moves until a blade has passed";
        std::mt19937 random(5);
        for (int i = 0; i < 12; ++i) {
            test_support::random_change(session, random, box, [&](const mesh::MeshDelta& delta) {
                online.apply(delta);
                online.set_wound(session.lips());
            });
            Eigen::VectorXd right = released(session, tension);
            right.conservativeResizeLike(Eigen::VectorXd::Zero(online.load().size()));
            constexpr double kRoundOff = 1e-15; // N; sums of some dozen loads of about 0.01 N
            EXPECT_LT((online.load() - right).lpNorm<Eigen::Infinity>(), kRoundOff);
            const OnlineStiffness fresh(session, tissue, tension);
            EXPECT_EQ(online.load().head(fresh.load().size()), fresh.load()) << "to the bit, change " << i;
        }
        EXPECT_GT(online.load().norm(), 0.0);
    }

    /// A tension along a slanted direction is a product of rotations, and rounding makes its pairs differ.
    TEST(OnlineStiffness, ATensionAlongADirectionIsSymmetricButForRounding)
    {
        mesh::CutSession session(layered_box());
        const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
        std::vector<Mat3> exact = tension(), rounded = exact;
        for (std::size_t t = 0; t < exact.size(); ++t) {
            const Mat3 turned = turn * exact[t] * turn.transpose();
            exact[t] = 0.5 * (turned + turned.transpose());
            rounded[t] = exact[t];
            rounded[t](0, 1) *= 1.0 + 1e-15;
        }
        OnlineStiffness online(session, kTissues, rounded), reference(session, kTissues, exact);
        std::mt19937 random(5);
        test_support::random_change(session, random, layered_box().vertices.colwise().maxCoeff().transpose(),
            [&](const mesh::MeshDelta& delta) {
                for (OnlineStiffness* each : { &online, &reference }) {
                    each->apply(delta);
                    each->set_wound(session.lips());
                }
            });
        ASSERT_GT(reference.load().norm(), 0.0);
        constexpr double kRoundOff = 1e-15; // N; sums of some dozen loads of about 0.01 N
        EXPECT_LT((online.load() - reference.load()).lpNorm<Eigen::Infinity>(), kRoundOff);
    }

    template <class Call> void expect_refused(const Call& call, const std::string& what, const std::string& where)
    {
        try {
            call();
            FAIL() << "not refused: " << what;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
            EXPECT_EQ(error.where(), where);
        }
    }

    TEST(OnlineStiffness, RefusesWhatDoesNotFitAndStaysAsItWas)
    {
        mesh::CutSession session(layered_box());
        OnlineStiffness online(session, kTissues);
        const OnlineStiffness before = online;
        mesh::MeshDelta gone;
        gone.tets_gone.push_back({ 3, { 0, 1, 2, 3 }, 1, 3 });
        expect_refused([&] { online.apply(gone); }, "an element that goes is not there", "element 3");
        mesh::MeshDelta nan;
        nan.vertices_moved.push_back({ 5, Vec3::Zero(), Vec3(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0) });
        expect_refused([&] { online.apply(nan); }, "not finite", "vertex 5");
        mesh::MeshDelta twice;
        twice.vertices_born.push_back({ 5, Vec3::Zero(), 5, 5, 0.0 });
        expect_refused([&] { online.apply(twice); }, "a vertex is born that lives", "vertex 5");
        expect_same_bits(online, before);
        expect_refused(
            [&] { OnlineStiffness(session, std::vector<Material> { kTissues[0] }); }, "no material", "label 1");
        expect_refused([&] { online.set_bed({ 1.0, -2.0 }); }, "not negative", "vertex 1");
        Mat3 lopsided = Mat3::Zero();
        lopsided(0, 1) = 1.0;
        std::vector<Mat3> stresses = tension();
        stresses[7] = lopsided;
        expect_refused([&] { OnlineStiffness(session, kTissues, stresses); }, "symmetric", "tension of element 7");
        stresses = tension();
        stresses.pop_back();
        expect_refused([&] { OnlineStiffness(session, kTissues, stresses); }, "one tension per element",
            "element " + std::to_string(stresses.size()));
        OnlineStiffness tense(session, kTissues, tension());
        expect_refused(
            [&] {
                tense.set_wound(std::vector<mesh::LipFace> { { { 999999, 0 }, 1, 0 } });
            },
            "the wound has a face that is not in the mesh", "element 999999");
    }

} // namespace online_stiffness_test
} // namespace retractor::fem
