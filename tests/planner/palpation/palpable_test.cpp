#include "planner/palpation/palpable.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace retractor::planner {
namespace palpable_test {

    constexpr double kRadius = 12.0, kLength = 120.0; // mm
    constexpr double kTubeX = 40.0, kTubeY = 40.0;

    /// A vessel along z through the whole image (x, y 0 to 80, z 0 to 120 mm), or from 30 to 90 mm only; a spine behind
    /// it that touches it between 50 and 60 mm; a liver of 20 mm and, on it, a stomach, in the corner.
    mesh::LabelVolume patient(bool whole)
    {
        mesh::LabelVolume labels;
        labels.grid.size = { 41, 41, 61 };
        labels.grid.spacing = { 2.0, 2.0, 2.0 };
        labels.table = { { 3, "aorta", "vessel", mesh::Role::target }, { 5, "spine", "bone", mesh::Role::wall },
            { 6, "liver", "liver", mesh::Role::voxel }, { 7, "stomach", "muscle", mesh::Role::voxel },
            { 9, "gone", "vessel", mesh::Role::voxel } };
        for (int k = 0; k < 61; ++k)
            for (int j = 0; j < 41; ++j)
                for (int i = 0; i < 41; ++i) {
                    const Vec3 p = labels.grid.world(Vec3(i, j, k));
                    Label label = 0;
                    if (std::hypot(p.x() - kTubeX, p.y() - kTubeY) <= kRadius
                        && (whole || std::abs(p.z() - 60.0) <= 30.0))
                        label = 3;
                    else if (p.y() > kTubeY && std::abs(p.x() - kTubeX) < 10.0 && std::abs(p.z() - 55.0) < 5.0)
                        label = 5;
                    else if (p.x() < 20.0 && p.y() < 24.0 && p.z() > 10.0 && p.z() < 50.0)
                        label = p.z() < 30.0 ? 6 : 7;
                    labels.voxels.push_back(label);
                }
        return labels;
    }

    Palpable make(const mesh::LabelVolume& labels, const PalpableRequest& request)
    {
        return make_palpable(labels, fem::default_materials(), request);
    }

    std::string refusal(const PalpableRequest& request, bool whole = true)
    {
        try {
            make(patient(whole), request);
        } catch (const InputError& error) {
            return error.where() + ": " + error.what();
        }
        return "no refusal";
    }

    std::size_t count(const datasets::ElasticModel& body, datasets::VertexRole role)
    {
        return static_cast<std::size_t>(std::count(body.roles.begin(), body.roles.end(), role));
    }

    TEST(Palpable, AVesselIsAWallWithBloodInsideHeldWhereItIsCutOff)
    {
        const Palpable made = make(patient(true), { .structure = { "aorta" }, .held = { "border" } });
        const datasets::ElasticModel& body = made.scene.body;
        EXPECT_TRUE(datasets::has_inner_wall(body));
        double volume = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(body.mesh.tet_count()); ++t)
            volume += mesh::tet_volume(body.mesh, t);
        constexpr double kWall = 2.0;
        const double inner = kRadius - kWall;
        const double exact
            = std::numbers::pi * (kLength * (kRadius * kRadius - inner * inner) + 2.0 * kWall * inner * inner);
        EXPECT_NEAR(volume, exact, 0.1 * exact); // voxels of 2 mm, smoothed, chords of 5 mm
        for (std::size_t v = 0; v < body.roles.size(); ++v)
            if (body.roles[v] == datasets::VertexRole::fixed) {
                const double z = body.mesh.vertices(static_cast<Eigen::Index>(v), 2);
                EXPECT_LT(std::min(std::abs(z), std::abs(kLength - z)), 6.0) << v;
            }
        EXPECT_GT(count(body, datasets::VertexRole::fixed), 10U);
        EXPECT_DOUBLE_EQ(
            body.youngs_modulus.front(), fem::find_material(fem::default_materials(), "vessel").youngs_modulus_MPa);
    }

    TEST(Palpable, SitesLookOutwardsAndFaceTheirOpposites)
    {
        const datasets::PalpationScene scene = make(patient(true), { .structure = { "aorta" } }).scene;
        const datasets::TouchSite& front = scene.site("front");
        EXPECT_NEAR(front.point.y(), kTubeY - kRadius, 1.5);
        EXPECT_LT(front.outward.y(), -0.85);
        const datasets::TouchSite& back = scene.site("front-opposite");
        EXPECT_NEAR(back.point.y(), kTubeY + kRadius, 2.5);
        EXPECT_LT(back.outward.dot(front.outward), -0.5);
        EXPECT_GT(scene.site("left").point.x(), kTubeX);
        EXPECT_LT(scene.site("right").point.x(), kTubeX);
    }

    TEST(Palpable, WhatLiesNextToItHoldsItAndItsEndsDo)
    {
        const datasets::ElasticModel by_spine
            = make(patient(false), { .structure = { "aorta" }, .held = { "spine" } }).scene.body;
        for (std::size_t v = 0; v < by_spine.roles.size(); ++v)
            if (by_spine.roles[v] == datasets::VertexRole::fixed) {
                const Vec3 p = by_spine.mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose();
                EXPECT_GT(p.y(), kTubeY);
                EXPECT_NEAR(p.z(), 55.0, 10.0);
            }
        const datasets::ElasticModel by_ends
            = make(patient(false), { .structure = { "aorta" }, .held = { "ends:20" } }).scene.body;
        std::size_t low = 0, high = 0;
        for (std::size_t v = 0; v < by_ends.roles.size(); ++v)
            if (by_ends.roles[v] == datasets::VertexRole::fixed) {
                const double z = by_ends.mesh.vertices(static_cast<Eigen::Index>(v), 2);
                EXPECT_GT(std::abs(z - 60.0), 10.0);
                (z < 60.0 ? low : high) += 1;
            }
        EXPECT_GT(low, 10U);
        EXPECT_GT(high, 10U);
        EXPECT_NE(refusal({ .structure = { "aorta" }, .held = { "border" } }, false).find("nothing holds it"),
            std::string::npos);
    }

    TEST(Palpable, EndsAreTheLargestPiecesAndOthersAreNotHeldByThem)
    {
        mesh::LabelVolume labels = patient(false); // and a piece of its own in a corner, which is met first
        const auto apart = [](const Vec3& p) { return p.x() > 60.0 && p.y() < 20.0 && p.z() < 30.0; };
        for (int k = 0; k < 61; ++k)
            for (int j = 0; j < 41; ++j)
                for (int i = 0; i < 41; ++i)
                    if (apart(labels.grid.world(Vec3(i, j, k))))
                        labels.voxels[labels.grid.offset(i, j, k)] = 3;
        PalpableRequest request { .structure = { "aorta" }, .wall_mm = 0.0, .edge_mm = 5.0, .held = { "ends:20" } };
        try {
            make(labels, request);
            FAIL() << "a piece that nothing holds";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("nothing holds a piece of it"), std::string::npos) << error.what();
        }
        request.held = { "ends:20", "border" };
        const datasets::ElasticModel body = make(labels, request).scene.body;
        std::size_t low = 0, high = 0, border = 0, free = 0;
        for (std::size_t v = 0; v < body.roles.size(); ++v) {
            const Vec3 p = body.mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose();
            const bool fixed = body.roles[v] == datasets::VertexRole::fixed;
            if (p.x() < 56.0 && fixed) {
                EXPECT_GT(std::abs(p.z() - 60.0), 10.0);
                (p.z() < 60.0 ? low : high) += 1;
            } else if (p.x() > 56.0)
                (fixed ? border : free) += 1;
        }
        EXPECT_GT(low, 10U);
        EXPECT_GT(high, 10U);
        EXPECT_GT(border, 3U);
        EXPECT_GT(free, 10U); // the sides of the other piece that the image does not cut off
    }

    TEST(Palpable, AStiffPlaceIsStiffAndHasASite)
    {
        const Vec3 at(kTubeX, kTubeY - kRadius, 60.0);
        const datasets::PalpationScene scene
            = make(patient(true), { .structure = { "aorta" }, .stiff = { { { "", at, 10.0 }, 3.0 } } }).scene;
        std::size_t stiff = 0;
        for (std::size_t t = 0; t < scene.body.mesh.tet_count(); ++t) {
            Vec3 middle = Vec3::Zero();
            for (const VertexId v : scene.body.mesh.tet(static_cast<TetId>(t)))
                middle += 0.25 * scene.body.mesh.vertices.row(v).transpose();
            const bool inside = (middle - at).norm() <= 10.0;
            EXPECT_DOUBLE_EQ(scene.body.youngs_modulus[t], inside ? 3.0 : 1.0);
            EXPECT_EQ(scene.body.mesh.labels[t], inside ? 2 : 1);
            stiff += inside ? 1 : 0;
        }
        EXPECT_GT(stiff, 10U);
        EXPECT_LT((scene.site("stiff-1").point - at).norm(), 4.0);
        EXPECT_NE(refusal({ .structure = { "aorta" }, .stiff = { { { "", Vec3::Zero(), 1.0 }, 3.0 } } })
                      .find("stiff place 1: no element"),
            std::string::npos);
    }

    TEST(Palpable, SolidOrgansKeepTheirElasticityAndTouch)
    {
        const datasets::PalpationScene scene
            = make(patient(true), { .structure = { "liver", "stomach" }, .edge_mm = 6.0, .held = { "border" } }).scene;
        EXPECT_FALSE(datasets::has_inner_wall(scene.body));
        ASSERT_EQ(scene.organs.size(), 2U);
        for (std::size_t t = 0; t < scene.body.mesh.tet_count(); ++t)
            EXPECT_DOUBLE_EQ(scene.body.youngs_modulus[t],
                fem::find_material(fem::default_materials(), scene.body.mesh.labels[t] == 1 ? "liver" : "muscle")
                    .youngs_modulus_MPa);
        // The border holds its faces x = 0 and y = 0.
        for (std::size_t v = 0; v < scene.body.roles.size(); ++v)
            if (scene.body.roles[v] == datasets::VertexRole::fixed) {
                EXPECT_LT(scene.body.mesh.vertices.row(static_cast<Eigen::Index>(v)).leftCols(2).minCoeff(), 4.0);
            }
    }

    TEST(Palpable, WhatIsTooThinForItsElementsIsToldOfEdges)
    {
        mesh::LabelVolume sheet; // 160 x 160 x 6 mm
        sheet.grid.size = { 81, 81, 9 };
        sheet.grid.spacing = { 2.0, 2.0, 2.0 };
        sheet.table = { { 1, "skin", "muscle", mesh::Role::wall } };
        for (int k = 0; k < 9; ++k)
            sheet.voxels.insert(sheet.voxels.end(), std::size_t { 81 } * 81, k >= 3 && k < 6 ? 1 : 0);
        try {
            make(sheet, { .structure = { "skin" }, .edge_mm = 40.0, .held = { "left:20" } });
            FAIL() << "elements of 40 mm fit in 6 mm";
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("thin tissue"), std::string::npos) << error.what();
            EXPECT_EQ(std::count(error.fields().begin(), error.fields().end(), "edge_mm"), 1);
        }
    }

    TEST(Palpable, WhatIsWrongIsNamed)
    {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const auto expect = [](const PalpableRequest& request, const std::string& text) {
            const std::string said = refusal(request);
            EXPECT_NE(said.find(text), std::string::npos) << said;
        };
        expect(
            { .structure = { "arota" } }, "structure: there is no structure \"arota\"; there are aorta, spine, liver");
        expect({ .structure = { "gone" } }, "structure gone: has no voxel");
        expect({ .structure = { "aorta", "aorta" } }, "named twice");
        expect({ .structure = { "aorta" }, .wall_mm = nan },
            "thickness of the wall (mm; 0: solid): must lie between 0.5 and 20");
        expect({ .structure = { "aorta" }, .wall_mm = -1.0 },
            "thickness of the wall (mm; 0: solid): must lie between 0.5 and 20");
        expect({ .structure = { "aorta" }, .edge_mm = 0.0 },
            "length of the edges (mm): must lie between 1 and 40, not at 0");
        expect({ .structure = { "aorta" }, .youngs_modulus_MPa = 1e-5 },
            "Young's modulus (MPa): must lie between 0.0001 and 10000, not at 1e-05");
        expect({ .structure = { "aorta" }, .poissons_ratio = 0.5 },
            "Poisson's ratio: must lie between 0 and 0.495, not at 0.5");
        expect({}, "structure: names what to palpate; there are aorta, spine, liver");
        expect({ .structure = { "aorta" }, .held = { "foot:ten" } }, "held foot:ten: a side is head");
        expect({ .structure = { "aorta" }, .held = { "rib" } }, "held: there is no structure \"rib\"");
        expect({ .structure = { "aorta" }, .held = { "aorta" } }, "does not hold itself");
        expect({ .structure = { "aorta" }, .sites = { { "here", Vec3(nan, 0, 0) } } }, "site here: sites have");
    }

} // namespace palpable_test
} // namespace retractor::planner
