#include "planner/session/tissue_choice.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace retractor::planner {
namespace tissue_choice_test {

    /// A block of 40 x 40 x 20 mm, held below; only cells for which `stays`.
    datasets::PalpationScene block(auto stays)
    {
        const mesh::TetMesh whole = mesh::kuhn_box(8, 8, 4, 5.0);
        datasets::PalpationScene scene;
        scene.name = "block";
        std::vector<VertexId> number(whole.vertex_count(), -1), kept;
        for (TetId t = 0; t < static_cast<TetId>(whole.tet_count()); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : whole.tet(t))
                middle += 0.25 * whole.vertices.row(v).transpose();
            if (!stays(middle))
                continue;
            for (const VertexId v : whole.tet(t)) {
                VertexId& n = number[static_cast<std::size_t>(v)];
                if (n < 0) {
                    n = static_cast<VertexId>(kept.size());
                    kept.push_back(v);
                }
                scene.body.mesh.nodes.push_back(n);
            }
            scene.body.mesh.labels.push_back(1);
        }
        scene.body.mesh.vertices = whole.vertices(kept, Eigen::all);
        for (Eigen::Index v = 0; v < scene.body.mesh.vertices.rows(); ++v)
            scene.body.roles.push_back(
                scene.body.mesh.vertices(v, 2) == 0.0 ? datasets::VertexRole::fixed : datasets::VertexRole::free);
        scene.body.youngs_modulus.assign(scene.body.mesh.tet_count(), 0.01);
        scene.body.poissons_ratio.assign(scene.body.mesh.tet_count(), 0.45);
        scene.sites = { { "top", { 10.0, 10.0, 20.0 }, Vec3::UnitZ() } };
        return scene;
    }

    const auto kAll = [](const Vec3&) { return true; };

    /// The force on a fingertip, slowly pressed 3 mm into the first site.
    double pressed(haptics::TissueResponse& tissue, const datasets::PalpationScene& scene, const TissueChoice& choice)
    {
        constexpr double kTick = 1e-3, kDepth = 3.0;
        constexpr int kTicks = 500, kHold = 1500, kTicksPerFrame = 16;
        haptics::Fingertip tip { Vec3::Zero(), Vec3::Zero(), choice.radius_mm };
        haptics::FingerContact contact;
        Points deformed;
        for (int i = 0; i < kHold; ++i) {
            const double depth = -1.0 + (kDepth + 1.0) * std::min(1.0, i / static_cast<double>(kTicks));
            tip.position = scene.sites[0].point + (choice.radius_mm - depth) * scene.sites[0].outward;
            tissue.tick(i * kTick, kTick, { &tip, 1 }, { &contact, 1 });
            if (i % kTicksPerFrame == 0)
                tissue.follow(deformed);
        }
        return contact.force.norm();
    }

    TissueChoice choice_of(const std::string& model)
    {
        TissueChoice choice;
        choice.model = model;
        choice.radius_mm = 6.0;
        choice.depth_mm = 3.0;
        choice.spheres = 1000;
        choice.fingertip = "sphere"; // as spheres and springs have it
        return choice;
    }

    TEST(TissueChoice, EveryModelHasABlocksForceToAFactorOfThree)
    {
        datasets::PalpationScene scene = block(kAll);
        scene.sites[0].point = { 20.0, 20.0, 20.0 }; // far from its edges
        std::vector<double> force;
        for (const std::string& model : tissue_models()) {
            const TissueChoice choice = choice_of(model);
            const ChosenTissue tissue = make_tissue(scene, choice, {});
            EXPECT_EQ(tissue.response->name(), model);
            force.push_back(pressed(*tissue.response, scene, choice));
            EXPECT_GT(force.back(), force.front() / 3.0) << model; // what each is off: retractor-bench palpate
            EXPECT_LT(force.back(), force.front() * 3.0) << model;
        }
        EXPECT_EQ(force.size(), 3U);
    }

    TEST(TissueChoice, SpheresFillABodyThatTouchesItselfAlongAnEdge)
    {
        // Two quarters of the block that meet in its middle line only, above a common floor.
        const datasets::PalpationScene scene
            = block([](const Vec3& p) { return p.z() < 5.0 || (p.x() < 20.0) == (p.y() < 20.0); });
        const TissueChoice choice = choice_of("spheres");
        const ChosenTissue tissue = make_tissue(scene, choice, {});
        EXPECT_GT(pressed(*tissue.response, scene, choice), 0.01);
    }

    TEST(TissueChoice, WhatDoesNotGoTogetherIsNamed)
    {
        const auto refused = [](const datasets::PalpationScene& scene, const TissueChoice& choice) -> std::string {
            try {
                static_cast<void>(make_tissue(scene, choice, {}));
            } catch (const InputError& error) {
                return error.where() + ": " + error.what();
            }
            return {};
        };
        datasets::PalpationScene vessel = block(kAll);
        vessel.body.roles.back() = datasets::VertexRole::inner_wall;
        EXPECT_NE(refused(vessel, choice_of("spheres")).find("use the model fem or springs"), std::string::npos);
        TissueChoice small = choice_of("springs");
        small.radius_mm = 0.1;
        small.depth_mm = 0.05;
        EXPECT_NE(refused(block(kAll), small).find("would fall between particles"), std::string::npos);
        EXPECT_FALSE(refused(block(kAll), choice_of("jelly")).empty());
    }

} // namespace tissue_choice_test
} // namespace retractor::planner
