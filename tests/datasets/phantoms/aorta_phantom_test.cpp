#include "datasets/phantoms/aorta_phantom.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "mesh/base/error.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

namespace retractor::datasets {
namespace aorta_phantom_test {

    double volume(const mesh::TetMesh& mesh, Label label)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (label == 0 || mesh.labels[static_cast<std::size_t>(t)] == label)
                sum += mesh::tet_volume(mesh, t);
        return sum;
    }

    TEST(AortaPhantom, TubeHasItsVolumeAndTheVolumeOfItsRegion)
    {
        AortaParameters p;
        p.shape = AortaParameters::Shape::tube;
        p.region = { 30.0, 120.0 };
        p.around = 48;
        const mesh::TetMesh mesh = make_aorta_phantom(p).body.mesh;
        const double wall = std::numbers::pi * (14.5 * 14.5 - 12.5 * 12.5);
        // 48 flat sides instead of a circle.
        const double polygon = 48 / (2 * std::numbers::pi) * std::sin(2 * std::numbers::pi / 48);
        EXPECT_NEAR(volume(mesh, 0) / (100.0 * wall * polygon), 1.0, 1e-9);
        EXPECT_NEAR(volume(mesh, 2) / (30.0 / 3 * wall), 1.0, 5e-3);
    }

    TEST(AortaPhantom, ArchIsAboutTheSourcesSize)
    {
        const PalpationScene scene = make_aorta_phantom({});
        EXPECT_NEAR(static_cast<double>(scene.body.mesh.vertex_count()), 1651.0, 0.01 * 1651);
        EXPECT_EQ(mesh::connected_pieces(scene.body.mesh), std::vector<int>(scene.body.mesh.tet_count(), 0));
        const auto count
            = [&](VertexRole role) { return std::count(scene.body.roles.begin(), scene.body.roles.end(), role); };
        EXPECT_EQ(count(VertexRole::fixed) + count(VertexRole::free), 860); // the ends, and what branches hold
        EXPECT_GT(count(VertexRole::fixed), 90);
        EXPECT_EQ(count(VertexRole::inner_wall), 780);
        EXPECT_GT(std::count(scene.body.youngs_modulus.begin(), scene.body.youngs_modulus.end(), 3.0), 100);
        EXPECT_GT(std::count(scene.body.youngs_modulus.begin(), scene.body.youngs_modulus.end(), 1.0), 100);
    }

    TEST(AortaPhantom, SitesLieOnTheOuterWallAndRegions)
    {
        const PalpationScene scene = make_aorta_phantom({});
        ASSERT_EQ(scene.sites.size(), 4U);
        for (const TouchSite& site : scene.sites) {
            const Points& v = scene.body.mesh.vertices;
            const double nearest = (v.rowwise() - site.point.transpose()).rowwise().norm().minCoeff();
            EXPECT_LT(nearest, 4.0) << site.name; // less than an element
            EXPECT_NEAR(site.outward.norm(), 1.0, 1e-12);
        }
        EXPECT_THROW(static_cast<void>(scene.site("left")), InputError);
        EXPECT_NEAR((scene.site("normal").point - scene.site("normal-opposite").point).norm(), 29.0, 1e-9);
    }

    TEST(AortaPhantom, MidpointsLieOnTheWall)
    {
        AortaParameters p;
        p.shape = AortaParameters::Shape::tube;
        p.nodes_per_tet = 10;
        p.around = 12;
        p.along = 8;
        const ElasticModel body = make_aorta_phantom(p).body;
        EXPECT_EQ(body.roles.size(), body.mesh.vertex_count());
        for (std::size_t v = 0; v < body.roles.size(); ++v)
            if (body.roles[v] == VertexRole::inner_wall) {
                EXPECT_NEAR(body.mesh.vertices.row(static_cast<Eigen::Index>(v)).head<2>().norm(), 12.5, 1e-9);
            }
    }

    TEST(AortaPhantom, SceneIsReadAsItWasWritten)
    {
        const test_support::TemporaryFolder folder;
        const PalpationScene scene = make_aorta_phantom({});
        write_palpation_scene(folder / "aorta.json", scene);
        const PalpationScene again = read_palpation_scene(folder / "aorta.json");
        EXPECT_EQ(again.body.mesh.vertices, scene.body.mesh.vertices);
        EXPECT_EQ(again.body.mesh.nodes, scene.body.mesh.nodes);
        EXPECT_EQ(again.body.roles, scene.body.roles);
        EXPECT_EQ(again.body.youngs_modulus, scene.body.youngs_modulus);
        EXPECT_EQ(again.body.poissons_ratio, scene.body.poissons_ratio);
        EXPECT_EQ(again.site("sclerotic").point, scene.site("sclerotic").point);
        EXPECT_EQ(again.rest_mmHg, 80.0);
    }

    std::string refusal(const std::filesystem::path& file)
    {
        try {
            read_palpation_scene(file);
        } catch (const Error& error) {
            return error.where() + ": " + error.what();
        }
        return "accepted";
    }

    TEST(AortaPhantom, OrgansAndSheetsOfASceneAreReadAsTheyWereWritten)
    {
        const test_support::TemporaryFolder folder;
        PalpationScene scene = make_aorta_phantom({});
        const Label label = scene.body.mesh.labels.front();
        scene.organs = { { label, "wall" } };
        scene.sheet_particles = 25;
        const std::filesystem::path file = folder / "organs.json";
        write_palpation_scene(file, scene);
        const PalpationScene again = read_palpation_scene(file);
        ASSERT_EQ(again.organs.size(), 1U);
        EXPECT_EQ(again.organs[0].name, "wall");
        EXPECT_EQ(again.organs[0].label, label);
        EXPECT_EQ(again.sheet_particles, 25);
        scene.organs = { { 200, "ghost" } };
        write_palpation_scene(file, scene);
        EXPECT_THROW(read_palpation_scene(file), InputError);
        scene.organs.clear();
        scene.sheet_particles = 2;
        write_palpation_scene(file, scene);
        EXPECT_THROW(read_palpation_scene(file), InputError);
    }

    TEST(AortaPhantom, BadScenesAreRefusedByPointer)
    {
        const test_support::TemporaryFolder folder;
        const auto file = folder / "aorta.json";
        write_palpation_scene(file, make_aorta_phantom({}));
        std::ifstream in(file);
        const std::string good { std::istreambuf_iterator<char>(in), {} };
        const auto with = [&](const std::string& from, const std::string& to) {
            std::string text = good;
            text.replace(text.find(from), from.size(), to);
            std::ofstream(file) << text;
            return refusal(file);
        };
        EXPECT_NE(with("\"LPS\"", "\"RAS\"").find("/frame"), std::string::npos);
        EXPECT_NE(with("\"rest_mmHg\": 80.0", "\"rest_mmHg\": null").find("/pressure/rest_mmHg"), std::string::npos);
        EXPECT_NE(with("\"mesh\": \"aorta.vtu\"", "\"mesh\": \"../aorta.vtu\"").find("/mesh"), std::string::npos);
        EXPECT_NE(with("aorta.vtu", "other.vtu").find("other.vtu"), std::string::npos);
        EXPECT_NE(with("\"outward\"", "\"inward\"").find("/sites/0/outward"), std::string::npos);
        EXPECT_NE(refusal(folder / "none.json").find("none.json"), std::string::npos);
        EXPECT_NE(
            with("retractor palpation scene", "something").find("is no retractor palpation scene"), std::string::npos);
        EXPECT_NE(with("\"retractor palpation scene\"", "7").find("/format: must be a text"), std::string::npos);
    }

    TEST(AortaPhantom, BadParametersAreRefused)
    {
        AortaParameters p;
        p.outer_radius_mm = 12.0;
        EXPECT_THROW(make_aorta_phantom(p), InputError);
        p = {};
        p.region.angle_deg = 0.0;
        EXPECT_THROW(make_aorta_phantom(p), InputError);
        p = {};
        p.around = 2;
        EXPECT_THROW(make_aorta_phantom(p), InputError);
        p = {};
        p.normal_MPa = std::nan("");
        EXPECT_THROW(make_aorta_phantom(p), InputError);
        p = {};
        p.length_mm = -1.0;
        EXPECT_THROW(make_aorta_phantom(p), InputError);
    }

} // namespace aorta_phantom_test
} // namespace retractor::datasets
