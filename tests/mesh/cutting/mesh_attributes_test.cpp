#include "mesh/cutting/mesh_attributes.h"

#include "mesh/base/error.h"
#include "tests/support/session_state.h"

#include <gtest/gtest.h>

#include <limits>

namespace retractor::mesh {
namespace mesh_attributes_test {

    constexpr double kRoundOff = 1e-13; // of the field's size: a sum of four products, also where weights are negative
    const Vec3 kExtent(15.0, 15.0, 9.0);

    std::array<double, 2> linear(const Vec3& p)
    {
        return { 1.0 + p.dot(Vec3(0.3, -0.2, 0.5)), p.dot(Vec3(-0.1, 0.7, 0.2)) };
    }

    AttributeArrays fields_on(const TetMesh& mesh)
    {
        AttributeArrays fields;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            fields.texture.push_back(linear(mesh.vertices.row(v).transpose()));
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            fields.fibre.push_back(Vec3(1.0 + t, -2.0, 0.5 * t).normalized());
            fields.pre_strain.push_back({ 0.01 * t, 0.02, 0.0, 1e-3 * t, 0.0, 0.0 });
        }
        return fields;
    }

    bool same(const AttributeArrays& a, const AttributeArrays& b)
    {
        return a.fibre == b.fibre && a.pre_strain == b.pre_strain && a.texture == b.texture;
    }

    class Attributes : public testing::TestWithParam<double> { }; // snap: 0 moves no vertex

    TEST_P(Attributes, FollowTheirSession)
    {
        const TetMesh body = test_support::three_layers(5, 5, 3, 3.0);
        const AttributeArrays first = fields_on(body);
        std::size_t moved = 0;
        for (unsigned seed = 0; seed < 8; ++seed) {
            std::mt19937 random(seed);
            CutSession session(body);
            MeshAttributes attributes(body, first);
            std::vector<AttributeArrays> states { attributes.values() };
            for (int i = 0; i < 6; ++i) {
                CutResult result;
                try {
                    result = i % 3 == 2
                        ? session.ablate(test_support::random_marks(random, session, kExtent, 2.5))
                        : session.cut(test_support::random_stroke(random, kExtent), { .snap = GetParam() });
                } catch (const Error&) {
                    continue;
                }
                if (result.status != CutStatus::done)
                    continue;
                attributes.follow(result.delta, session);
                states.push_back(attributes.values());
                moved += result.delta.vertices_moved.size();

                // Fibre and pre-strain by the map to the first mesh, texture linear still.
                SlotMap map;
                const TetMesh mesh = session.compact_mesh(&map);
                const AttributeArrays compact = attributes.compact(map);
                ASSERT_EQ(compact.fibre.size(), mesh.tet_count());
                ASSERT_EQ(compact.texture.size(), mesh.vertex_count());
                for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
                    const auto origin = static_cast<std::size_t>(session.origin(map.tet_slot[t]));
                    ASSERT_EQ(compact.fibre[t], first.fibre[origin]);
                    ASSERT_EQ(compact.pre_strain[t], first.pre_strain[origin]);
                    ASSERT_EQ(mesh.labels[t], body.labels[origin]);
                }
                const double scale = linear(kExtent)[0];
                for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
                    const auto expected = linear(mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose());
                    for (std::size_t k = 0; k < 2; ++k)
                        ASSERT_NEAR(compact.texture[v][k], expected[k], 100.0 * kRoundOff * scale) << "vertex " << v;
                }
                // The same as from scratch.
                MeshAttributes fresh(body, first);
                fresh.take(session);
                ASSERT_TRUE(same(fresh.values(), attributes.values())) << "seed " << seed << " step " << i;
            }
            // Back and forth, to the last bit. Arrays never shrink: what is beyond the slots is zero or unused.
            const auto agree = [&](const AttributeArrays& state) {
                AttributeArrays now = attributes.values();
                AttributeArrays then = state;
                then.fibre.resize(now.fibre.size(), Vec3::Zero());
                then.pre_strain.resize(now.pre_strain.size(), {});
                then.texture.resize(now.texture.size(), {});
                return same(now, then);
            };
            for (std::size_t i = states.size() - 1; i > 0; --i) {
                attributes.follow(session.undo(), session);
                states[i - 1].fibre.resize(session.tet_slots());
                EXPECT_TRUE(agree(states[i - 1])) << "seed " << seed << " undo to " << i - 1;
            }
            for (std::size_t i = 1; i < states.size(); ++i) {
                attributes.follow(session.redo(), session);
                EXPECT_TRUE(agree(states[i])) << "seed " << seed << " redo to " << i;
            }
        }
        EXPECT_EQ(moved == 0, GetParam() == 0.0);
    }

    INSTANTIATE_TEST_SUITE_P(Snap, Attributes, testing::Values(0.0, 0.35));

    TEST(MeshAttributes, ABornVertexHasTheValueOfItsEdge)
    {
        // Not linear over the mesh, but linear in each element: what interpolation along the edge gives.
        const TetMesh body = test_support::three_layers(4, 4, 2, 3.0);
        AttributeArrays first;
        std::mt19937 random(7);
        std::uniform_real_distribution<double> unit(0.0, 1.0);
        for (std::size_t v = 0; v < body.vertex_count(); ++v)
            first.texture.push_back({ unit(random), unit(random) });
        CutSession session(body);
        MeshAttributes attributes(body, first);
        const CutResult result = session.cut(
            { .line = { { -1, 5.3, 6 }, { 13, 6.1, 6 } }, .directions = { { 0, 0.1, -1 } }, .depth_mm = 20.0 },
            { .snap = 0.0 });
        ASSERT_EQ(result.status, CutStatus::done);
        attributes.follow(result.delta, session);
        std::size_t checked = 0;
        for (const auto& born : result.delta.vertices_born) {
            if (static_cast<std::size_t>(std::max(born.a, born.b)) >= body.vertex_count())
                continue;
            ++checked;
            for (std::size_t k = 0; k < 2; ++k) {
                const auto at = [&](VertexId v) { return first.texture[static_cast<std::size_t>(v)][k]; };
                EXPECT_NEAR(attributes.values().texture[static_cast<std::size_t>(born.id)][k],
                    (1.0 - born.t) * at(born.a) + born.t * at(born.b), 1e-9); // put on the blade to 1e-10 of its size
            }
        }
        EXPECT_GT(checked, 20u);
    }

    TEST(MeshAttributes, WrongArraysAreRefusedByName)
    {
        const TetMesh body = kuhn_box(1, 1, 1, 1.0);
        AttributeArrays fields = fields_on(body);
        fields.fibre.pop_back();
        try {
            MeshAttributes attributes(body, fields);
            FAIL() << "a short array was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "fibre");
        }
        fields = fields_on(body);
        fields.texture[3][1] = std::numeric_limits<double>::quiet_NaN();
        try {
            MeshAttributes attributes(body, fields);
            FAIL() << "NaN was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "texture/3");
        }
    }

} // namespace mesh_attributes_test
} // namespace retractor::mesh
