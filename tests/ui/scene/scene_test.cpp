#include "ui/scene/scene.h"

#include "mesh/base/error.h"
#include "tests/ui/scene/sample_scenes.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/moving_scene.h"
#include "ui/scene/pick.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/annotations.h"
#include "ui/scene/vtk/identifier_picture.h"
#include "ui/scene/vtk/simplify_surface.h"
#include "ui/scene/vtk/slice_actor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>

namespace retractor::ui {
namespace scene_test {

    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    /// Sums of some thousand terms of order 100.
    constexpr double kRoundOff = 1e-9;

    Scene box() { return samples::box_scene({ -10, -10, -10 }, { 10, 10, 10 }, { 1, 0, 0 }); }

    TEST(SceneBounds, AreThoseOfItsItems)
    {
        Scene scene = box();
        scene.lines.push_back({ .name = "line", .points = { { 0, 0, 0 }, { 30, 0, 0 } } });
        const auto bounds = scene_bounds(scene);
        ASSERT_TRUE(bounds);
        EXPECT_EQ(bounds->low, Vec3(-10, -10, -10));
        EXPECT_EQ(bounds->high, Vec3(30, 10, 10));
        EXPECT_FALSE(scene_bounds(Scene {}));
    }

    TEST(CameraForBox, SeesTheWholeBoxFromTheGivenSide)
    {
        const Camera camera = camera_for_box({ { -10, -10, -10 }, { 10, 10, 10 } }, Vec3::UnitY(), Vec3::UnitZ(), 30.0);
        EXPECT_NEAR(camera.aim.norm(), 0.0, kRoundOff);
        const double radius = std::sqrt(300.0);
        EXPECT_NEAR(camera.eye.y(), -radius / std::sin(std::numbers::pi / 12.0), kRoundOff);
    }

    TEST(AnatomicalLetter, NamesLpsDirections)
    {
        EXPECT_EQ(anatomical_letter({ 1, 0, 0 }), 'L');
        EXPECT_EQ(anatomical_letter({ -1, 0.2, 0 }), 'R');
        EXPECT_EQ(anatomical_letter({ 0, 1, 0 }), 'P');
        EXPECT_EQ(anatomical_letter({ 0, -1, 0 }), 'A');
        EXPECT_EQ(anatomical_letter({ 0, 0, 1 }), 'S');
        EXPECT_EQ(anatomical_letter({ 0, 0, -1 }), 'I');
    }

    TEST(RoundLength, IsTheLongestRoundOneThatFits)
    {
        EXPECT_DOUBLE_EQ(round_length(49.9), 20.0);
        EXPECT_DOUBLE_EQ(round_length(50.0), 50.0);
        EXPECT_DOUBLE_EQ(round_length(1.5), 1.0);
        EXPECT_DOUBLE_EQ(round_length(0.3), 0.2);
    }

    TEST(SampleSlice, ReadsALinearImageExactlyOnAnObliquePlane)
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 30, 30, 30 }, .spacing = { 2, 2, 2 }, .origin = { -29, -29, -29 } };
        for (int k = 0; k < 30; ++k)
            for (int j = 0; j < 30; ++j)
                for (int i = 0; i < 30; ++i) {
                    const Vec3 p = image->grid.world(Vec3(i, j, k));
                    image->voxels.push_back(static_cast<std::int16_t>(std::lround(p.x() + p.y() + p.z())));
                }
        const Vec3 right = Vec3(1, 1, 0).normalized(), up = Vec3(-1, 1, 1).normalized();
        SliceItem slice { .image = image, .point = { 1, 2, 3 }, .window_hu = 255.0, .level_hu = 0.0 };
        slice.oblique = ObliqueSlice { .right = right, .up = up, .half_width_mm = 12.0, .half_height_mm = 8.0 };
        const SliceImage picture = sample_slice(slice);
        EXPECT_NEAR((picture.columns * picture.across - 24.0 * right).norm(), 0.0, kRoundOff);
        EXPECT_NEAR((picture.rows * picture.upward - 16.0 * up).norm(), 0.0, kRoundOff);
        for (int row = 0; row < picture.rows; ++row)
            for (int column = 0; column < picture.columns; ++column) {
                const Vec3 p = picture.corner + column * picture.across + row * picture.upward;
                const int got = picture.rgb[static_cast<std::size_t>(3 * (row * picture.columns + column))];
                ASSERT_NEAR(got, p.sum() + 127.5, 0.5 + kRoundOff);
            }
        // The camera looks straight at it, with the same right and up.
        const Camera camera = camera_for_slice(slice, 2.0);
        EXPECT_NEAR((camera.aim - slice.point).norm(), 0.0, kRoundOff);
        EXPECT_NEAR((camera.aim - camera.eye).normalized().cross(camera.up).dot(right), 1.0, kRoundOff);
        EXPECT_DOUBLE_EQ(camera.half_height_mm, 8.0);
        // Each pixel of the picture knows its label: one half of the plane is labelled.
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid = image->grid;
        for (const std::int16_t value : image->voxels)
            labels->voxels.push_back(value > 0 ? 5 : 0);
        slice.labels = labels;
        const IdentifierPicture named = identifier_picture(slice, camera, { { 5, "heart" } }, 80, 40);
        ASSERT_EQ(named.structure.size(), 3200U);
        EXPECT_EQ(named.structure[20 * 80 + 65], 0); // x + y + z grows to the right
        EXPECT_EQ(named.structure[20 * 80 + 75], -1) << "beyond the slice, which is 24 mm wide";
        EXPECT_EQ(named.structure[20 * 80 + 5], -1);
    }

    TEST(SampleSlice, ReadsALinearImageExactlyOnMirroredAxes)
    {
        // Grey is a linear function of the position, so trilinear interpolation must give it back anywhere inside.
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 12, 10, 8 }, .spacing = { 2, 2, 2 }, .origin = { 22, 0, 0 } };
        image->grid.direction << -1, 0, 0, 0, 1, 0, 0, 0, 1;
        for (int k = 0; k < 8; ++k)
            for (int j = 0; j < 10; ++j)
                for (int i = 0; i < 12; ++i) {
                    const Vec3 p = image->grid.world(Vec3(i, j, k));
                    image->voxels.push_back(static_cast<std::int16_t>(2 * p.x() + 3 * p.y() + 5 * p.z()));
                }
        SliceItem slice {
            .image = image, .plane = SlicePlane::coronal, .point = { 0, 7, 0 }, .window_hu = 255.0, .level_hu = 127.5
        };
        const SliceImage picture = sample_slice(slice);
        for (int row = 2; row + 2 < picture.rows; ++row)
            for (int column = 2; column + 2 < picture.columns; ++column) {
                const Vec3 p = picture.corner + column * picture.across + row * picture.upward;
                ASSERT_NEAR(p.y(), 7.0, kRoundOff);
                const double expected = std::min(255.0, 2 * p.x() + 3 * p.y() + 5 * p.z());
                const auto got = picture.rgb[3 * static_cast<std::size_t>(row * picture.columns + column)];
                ASSERT_NEAR(got, expected, 0.5 + kRoundOff); // rounded to a grey level
            }
    }

    TEST(SampleSlice, OutlinesLabelsInTheirColour)
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 20, 20, 3 } };
        image->voxels.assign(image->grid.voxel_count(), -2000);
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid = image->grid;
        labels->voxels.assign(image->grid.voxel_count(), 0);
        for (int j = 5; j < 15; ++j)
            for (int i = 5; i < 15; ++i)
                labels->voxels[labels->grid.offset(i, j, 1)] = 3;
        SliceItem slice { .image = image,
            .point = { 0, 0, 1 },
            .labels = labels,
            .outline_of_label = { { 3, { 1, 0, 0 } } },
            .fill = 0.0 };
        const SliceImage picture = sample_slice(slice);
        int red = 0;
        for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
            red += picture.rgb[i] == 255 && picture.rgb[i + 1] == 0 ? 1 : 0;
        EXPECT_EQ(red, 4 * (20 - 1)); // 10 mm at half a millimetre: the rim of 20 x 20 pixels
    }

    TEST(TissueLooks, EveryKnownMaterialLooksDifferent)
    {
        const std::array<std::string_view, 10> names { "skin", "fat", "muscle", "intercostal", "bone", "cartilage",
            "vessel", "heart", "lung", "liver" };
        for (std::size_t i = 0; i < names.size(); ++i)
            for (std::size_t j = i + 1; j < names.size(); ++j) {
                const Color a = tissue_look(names[i]).color, b = tissue_look(names[j]).color;
                EXPECT_GT(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 0.05)
                    << names[i] << ' ' << names[j];
            }
        const auto looks = tissue_looks({ { .id = 4, .name = "rib", .material = "bone", .role = mesh::Role::wall } });
        EXPECT_DOUBLE_EQ(looks.at(4).color.r, tissue_look("bone").color.r);
    }

    // What cannot be drawn is refused, and the message says why and where.

    struct Refusal {
        const char* message;
        std::function<void(Scene&)> spoil;
    };
    class RefusedScene : public testing::TestWithParam<Refusal> { };

    TEST_P(RefusedScene, NamesTheReason)
    {
        Scene scene = samples::little_chest(false);
        ASSERT_NO_THROW(check_scene(scene));
        GetParam().spoil(scene);
        try {
            check_scene(scene);
            FAIL() << "accepted: " << GetParam().message;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(GetParam().message), std::string::npos) << error.what();
            EXPECT_FALSE(error.where().empty());
        }
    }

    TriMesh& own_mesh(Scene& scene)
    {
        auto copy = std::make_shared<TriMesh>(*scene.surfaces[0].mesh);
        scene.surfaces[0].mesh = copy;
        return *copy;
    }

    INSTANTIATE_TEST_SUITE_P(Scenes, RefusedScene,
        testing::Values(Refusal { "vertex 3 is not finite", [](Scene& s) { own_mesh(s).vertices(3, 1) = kNaN; } },
            Refusal { "names vertex -1", [](Scene& s) { own_mesh(s).triangles[2][1] = -1; } },
            Refusal { "one label per triangle", [](Scene& s) { own_mesh(s).labels.pop_back(); } },
            Refusal { "label 9 has no look", [](Scene& s) { own_mesh(s).labels[4] = 9; } },
            Refusal { "has no mesh", [](Scene& s) { s.surfaces[0].mesh = nullptr; } },
            Refusal { "opacity must be within", [](Scene& s) { s.surfaces[0].opacity = kNaN; } },
            Refusal { "colour must be within", [](Scene& s) { s.surfaces[0].look.color.g = 200.0; } },
            Refusal { "eye is at its aim", [](Scene& s) { s.camera.aim = s.camera.eye; } },
            Refusal { "along its line of sight", [](Scene& s) { s.camera.up = s.camera.aim - s.camera.eye; } },
            Refusal { "camera is not finite", [](Scene& s) { s.camera.eye.x() = kNaN; } },
            Refusal { "view angle must be", [](Scene& s) { s.camera.view_angle_deg = 180.0; } },
            Refusal { "at least two points", [](Scene& s) { s.lines[0].points.resize(1); } },
            Refusal { "point that is not finite", [](Scene& s) { s.lines[0].points[0].z() = kNaN; } },
            Refusal { "has no image", [](Scene& s) { s.volumes.emplace_back(); } },
            Refusal { "does not match its size",
                [](Scene& s) {
                    auto ct = std::make_shared<mesh::Volume>(*samples::little_ct());
                    ct->voxels.pop_back();
                    s.volumes.emplace_back().image = ct;
                } },
            Refusal { "unit vectors at right angles",
                [](Scene& s) {
                    s.slices.push_back({ .image = samples::little_ct() });
                    s.slices.back().oblique = ObliqueSlice { .right = Vec3::UnitX(), .up = Vec3(1, 1, 0) };
                } },
            Refusal { "window must be positive",
                [](Scene& s) { s.slices.push_back({ .image = samples::little_ct(), .window_hu = 0.0 }); } }));

    TEST(Clustered, KeepsTheShapeWithinACubeAndTheLabelsOfItsTriangles)
    {
        TriMesh sphere = samples::sphere_mesh(Vec3(3.0, -20.0, 11.0), 40.0, 96);
        for (const auto& t : sphere.triangles)
            sphere.labels.push_back(sphere.vertices(t[0], 2) > 11.0 ? 1 : 2);
        constexpr double kCube = 5.0;
        const TriMesh fewer = clustered(sphere, kCube);
        EXPECT_LT(fewer.triangles.size(), sphere.triangles.size() / 3);
        EXPECT_GT(fewer.triangles.size(), 500U);
        ASSERT_EQ(fewer.labels.size(), fewer.triangles.size());
        for (Eigen::Index v = 0; v < fewer.vertices.rows(); ++v) {
            const double off
                = std::abs((point_at(fewer.vertices, static_cast<VertexId>(v)) - Vec3(3.0, -20.0, 11.0)).norm() - 40.0);
            EXPECT_LT(off, kCube * std::sqrt(3.0));
        }
        for (std::size_t t = 0; t < fewer.triangles.size(); ++t) {
            const double z = point_at(fewer.vertices, fewer.triangles[t][0]).z();
            EXPECT_TRUE(fewer.labels[t] == 1 ? z > 11.0 - 2.0 * kCube : z < 11.0 + 2.0 * kCube);
        }
        // The enclosed volume, by the divergence theorem: triangles keep their orientation.
        double volume = 0.0;
        for (const auto& t : fewer.triangles)
            volume += point_at(fewer.vertices, t[0])
                          .dot(point_at(fewer.vertices, t[1]).cross(point_at(fewer.vertices, t[2])))
                / 6.0;
        const double whole = 4.0 / 3.0 * std::numbers::pi * std::pow(40.0, 3);
        EXPECT_NEAR(volume, whole, 0.05 * whole) << "a mean of vertices lies a little inside";
    }

    TEST(Clustered, ACubeSmallerThanEveryEdgeLeavesTheSurfaceAsItIs)
    {
        const TriMesh box = samples::box_mesh(Vec3(1.0, 1.0, 1.0), Vec3(9.0, 9.0, 9.0));
        const TriMesh same = clustered(box, 0.1);
        EXPECT_EQ(same.triangles, box.triangles);
        EXPECT_TRUE(same.vertices.isApprox(box.vertices, 1e-12));
        EXPECT_EQ(clustered(box, 100.0).triangles.size(), 12U) << "its corners face eight octants";
        EXPECT_TRUE(clustered(TriMesh {}, 1.0).triangles.empty());
        for (const double cube :
            { 0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity() })
            EXPECT_THROW(clustered(box, cube), InputError);
        TriMesh broken = box;
        broken.vertices(0, 0) = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(clustered(broken, 1.0), InputError);
    }

    TEST(Clustered, TheTwoSidesOfASheetStayApartAndTheMiddleOfThePictureIsFiner)
    {
        const Vec3 centre(0.5, 0.5, 0.5);
        TriMesh sheet = samples::box_mesh(centre - Vec3(30.0, 30.0, 1.0), centre + Vec3(30.0, 30.0, 1.0));
        sheet = with_edges_at_most(sheet, 3.0);
        const TriMesh fewer = clustered(sheet, 8.0);
        EXPECT_LT(fewer.triangles.size(), sheet.triangles.size() / 3);
        for (Eigen::Index v = 0; v < fewer.vertices.rows(); ++v) {
            const Vec3 from_centre = point_at(fewer.vertices, static_cast<VertexId>(v)) - centre;
            if (from_centre.head<2>().cwiseAbs().maxCoeff() < 20.0) { // more than a cube from the rim
                EXPECT_NEAR(std::abs(from_centre.z()), 1.0, 1e-9) << "not between the two sides";
            }
        }

        const TriMesh ball = samples::sphere_mesh(Vec3::Zero(), 40.0, 96);
        const TriMesh partly = clustered(ball, 4.0, { .direction = Vec3::UnitZ(), .radius_mm = 15.0 });
        std::size_t in_middle = 0;
        const auto middle = [](const TriMesh& mesh, std::size_t t) {
            return point_at(mesh.vertices, mesh.triangles[t][0]).head<2>().norm() < 12.0;
        };
        for (std::size_t t = 0; t < partly.triangles.size(); ++t)
            in_middle += middle(partly, t) ? 1 : 0;
        const TriMesh alike = clustered(ball, 4.0);
        std::size_t in_middle_alike = 0;
        for (std::size_t t = 0; t < alike.triangles.size(); ++t)
            in_middle_alike += middle(alike, t) ? 1 : 0;
        EXPECT_GT(in_middle, in_middle_alike / 2);
        EXPECT_LT(partly.triangles.size(), alike.triangles.size() / 2);
    }

    /// Three slices of an image of 40 x 60 x 80 mm with a ball and a line.
    std::vector<Scene> linked_slices()
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid.size = { 21, 31, 41 };
        image->grid.spacing = { 2.0, 2.0, 2.0 };
        image->grid.origin = { -20.0, -30.0, -40.0 };
        image->voxels.assign(image->grid.voxel_count(), 55);
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid = image->grid;
        labels->voxels.assign(image->grid.voxel_count(), 3);
        std::vector<Scene> scenes;
        for (const SlicePlane plane : { SlicePlane::axial, SlicePlane::coronal, SlicePlane::sagittal }) {
            Scene scene;
            scene.slices.push_back({ .image = image, .plane = plane, .labels = labels });
            LineItem ball { .name = "target" };
            const int axis = axis_across(plane);
            for (int n = 0; n <= 32; ++n) {
                Vec3 p = Vec3::Zero();
                p[(axis + 1) % 3] = 10.0 * std::cos(2.0 * std::numbers::pi * n / 32);
                p[(axis + 2) % 3] = 10.0 * std::sin(2.0 * std::numbers::pi * n / 32);
                ball.points.push_back(p);
            }
            LineItem cut { .name = "incision", .points = { Vec3(1.0, 2.0, 3.0), Vec3(4.0, 5.0, 6.0) } };
            scene.lines = { ball, cut };
            scene.camera = camera_for_slice(scene.slices.front(), 1.0);
            scenes.push_back(std::move(scene));
        }
        return scenes;
    }

    TEST(LinkedSlices, LieThroughThePointWithTheirLinesAndSayWhatIsThere)
    {
        const Vec3 point(2.0, -4.0, 6.0);
        const std::vector<Scene> moved = slices_at(linked_slices(), point, { { 3, "aorta (estimated)" } });
        const std::array<double, 3> off { 6.0, 4.0, 2.0 };
        for (std::size_t i = 0; i < 3; ++i) {
            const SliceItem& slice = moved[i].slices.front();
            EXPECT_EQ(slice.point, point);
            const int axis = axis_across(slice.plane);
            ASSERT_EQ(moved[i].lines.size(), 4U) << "ball, cut and the two other planes";
            const LineItem& ball = moved[i].lines[0];
            Vec3 centre = Vec3::Zero();
            centre[axis] = point[axis];
            for (const Vec3& p : ball.points)
                EXPECT_NEAR((p - centre).norm(), std::sqrt(100.0 - off[i] * off[i]), kRoundOff);
            for (const LineItem& line : moved[i].lines)
                for (const Vec3& p : line.points)
                    EXPECT_NEAR(p[axis], point[axis], kRoundOff);
            EXPECT_NO_THROW(check_scene(moved[i]));
        }
        ASSERT_EQ(moved[0].notes.size(), 1U);
        EXPECT_EQ(moved[0].notes[0], "LPS 2, -4, 6 mm: 55 HU, aorta (estimated)");
        EXPECT_TRUE(moved[1].notes.empty());
        EXPECT_EQ(slices_at(linked_slices(), Vec3(0.0, 0.0, 30.0), {})[0].lines.size(), 2U) << "no ball, no cut there";
    }

    TEST(LinkedSlices, ShowTheIncisionOnlyWhereItLiesNearThem)
    {
        Scene scene = linked_slices()[0];
        scene.title = "axial";
        scene.lines = { { .name = "incision" } };
        for (int n = -40; n <= 40; ++n) // twice through the plane
            scene.lines[0].points.emplace_back(n, 0.0, std::abs(n) - 20.0);
        const Scene there = slice_with_lines(scene, Vec3::Zero());
        EXPECT_EQ(there.title, "axial, incision within 10 mm");
        ASSERT_EQ(there.lines.size(), 2U);
        for (const LineItem& part : there.lines) {
            EXPECT_EQ(part.points.size(), 21U); // 10 mm on both sides of 20 mm
            for (const Vec3& p : part.points) {
                EXPECT_EQ(p.z(), 0.0);
                EXPECT_LE(std::abs(std::abs(p.x()) - 20.0), kNearSliceMm);
            }
        }
        // One long segment through the plane is clipped, and goes on from one side to the other.
        scene.lines[0].points = { Vec3(0.0, 0.0, -40.0), Vec3(80.0, 0.0, 40.0) };
        const Scene through = slice_with_lines(scene, Vec3::Zero());
        ASSERT_EQ(through.lines.size(), 1U);
        ASSERT_EQ(through.lines[0].points.size(), 2U);
        EXPECT_NEAR((through.lines[0].points[0] - Vec3(30.0, 0.0, 0.0)).norm(), 0.0, kRoundOff);
        EXPECT_NEAR((through.lines[0].points[1] - Vec3(50.0, 0.0, 0.0)).norm(), 0.0, kRoundOff);
        scene.lines.push_back({ .name = "vessel", .points = scene.lines[0].points, .near_slice_mm = 2.0 });
        const Scene both = slice_with_lines(scene, Vec3::Zero());
        ASSERT_EQ(both.lines.size(), 2U);
        EXPECT_NEAR((both.lines[1].points[1] - both.lines[1].points[0]).norm(), 4.0, kRoundOff);
        // A line that passes straight through the slice is a dot.
        scene.lines[1].points = { Vec3(5.0, 6.0, -20.0), Vec3(5.0, 6.0, 20.0) };
        const std::vector<Vec3> dot = slice_with_lines(scene, Vec3::Zero()).lines[1].points;
        EXPECT_EQ(dot[0], Vec3(3.5, 6.0, 0.0));
        EXPECT_EQ(dot[1], Vec3(6.5, 6.0, 0.0));
        scene.lines[0].name = "another line";
        EXPECT_EQ(slice_with_lines(scene, Vec3::Zero()).title, "axial") << "no incision";
        const Scene far = slice_with_lines(scene, Vec3(0.0, 0.0, 60.0));
        EXPECT_TRUE(far.lines.empty());
        EXPECT_EQ(far.title, "axial");
    }

    TEST(LinkedSlices, StepsGoTowardsHeadFrontAndLeftAndStayWithinTheImage)
    {
        const std::vector<Scene> scenes = linked_slices();
        EXPECT_EQ(stepped(scenes[0].slices[0], 1.0), Vec3(0.0, 0.0, 2.0));
        EXPECT_EQ(stepped(scenes[1].slices[0], 1.0), Vec3(0.0, -2.0, 0.0));
        EXPECT_EQ(stepped(scenes[2].slices[0], -0.5), Vec3(-1.0, 0.0, 0.0));
        EXPECT_EQ(stepped(scenes[0].slices[0], 1e6), Vec3(0.0, 0.0, 40.0));
        // The middle of a picture is the middle of the image; its upper edge lies beyond the head's end.
        EXPECT_NEAR(place_on_slice(scenes[1].slices[0], scenes[1].camera, 0.5, 0.5, 1.0).norm(), 0.0, kRoundOff);
        EXPECT_NEAR(place_on_slice(scenes[1].slices[0], scenes[1].camera, 0.5, 1.0, 1.0).z(), 40.0, kRoundOff);
        // Right in the picture is the patient's left from the front.
        EXPECT_GT(place_on_slice(scenes[1].slices[0], scenes[1].camera, 0.6, 0.5, 1.0).x(), 1.0);
    }

    TEST(MovingScene, HasAboutTheAskedTrianglesAndNoTextures)
    {
        Scene scene = samples::little_chest(false);
        SurfaceItem sphere;
        sphere.mesh = std::make_shared<const TriMesh>(samples::sphere_mesh(Vec3::Zero(), 60.0, 300));
        sphere.look.texture = 1.0;
        scene.surfaces.push_back(sphere);
        constexpr std::size_t kAsked = 8000;
        const Scene moving = moving_scene(scene, kAsked);
        ASSERT_EQ(moving.surfaces.size(), scene.surfaces.size());
        std::size_t triangles = 0;
        for (const SurfaceItem& item : moving.surfaces) {
            triangles += item.mesh->triangles.size();
            EXPECT_EQ(item.look.texture, 0.0);
            for (const auto& [label, look] : item.look_of_label)
                EXPECT_EQ(look.texture, 0.0);
        }
        EXPECT_NEAR(static_cast<double>(triangles), kAsked, 0.5 * kAsked);
        EXPECT_NO_THROW(check_scene(moving));
        EXPECT_EQ(moving_scene(scene, 10'000'000).surfaces.back().mesh, sphere.mesh)
            << "a small scene keeps its meshes";
    }

    TEST(CheckPicture, RefusesEmptySizesAndViewports)
    {
        Picture picture;
        EXPECT_THROW(check_picture(picture), InputError);
        picture.viewports.push_back({ .scene = box() });
        EXPECT_NO_THROW(check_picture(picture));
        picture.width = 0;
        EXPECT_THROW(check_picture(picture), InputError);
        picture.width = 100;
        picture.viewports[0].right = 0.0;
        EXPECT_THROW(check_picture(picture), InputError);
    }

    TEST(Pick, GivesTheNearestOfWhatIsShown)
    {
        Scene scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, {});
        scene.surfaces[0].name = "body";
        scene.surfaces.push_back(samples::unlit(samples::box_mesh({ -10, -10, -10 }, { 10, 10, 10 }, 7), {}));
        scene.surfaces[1].name = "heart";
        const Vec3 eye(1.0, -600.0, 2.0), ahead = Vec3::UnitY();
        const auto skin = pick(scene, eye, ahead);
        ASSERT_TRUE(skin);
        EXPECT_EQ(skin->name, "body");
        EXPECT_NEAR((skin->place - Vec3(1.0, -50.0, 2.0)).norm(), 0.0, kRoundOff);
        EXPECT_FALSE(pick(scene, eye, -ahead)) << "behind the eye";
        EXPECT_FALSE(pick(scene, { 0.0, -600.0, 60.0 }, ahead)) << "beside";
        scene.surfaces[0].opacity = 0.2; // looked through
        EXPECT_EQ(pick(scene, eye, ahead)->name, "heart");
        EXPECT_EQ(pick(scene, eye, ahead)->label, 7);
        EXPECT_EQ(pick(scene, { 40.0, -600.0, 40.0 }, ahead)->name, "body") << "nothing stands behind it";
        scene.surfaces[0].opacity = 1.0;
        scene.cut_away = CutAway { .point = { 0.0, 5.0, 0.0 } };
        EXPECT_NEAR(pick(scene, eye, ahead)->place.y(), 10.0, kRoundOff) << "the front of the heart is cut away, too";
    }

    TEST(Pick, MeetsTheFaceOfTheCutWhereItHasLabels)
    {
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid = { .size = { 3, 3, 3 }, .spacing = { 10, 10, 10 }, .origin = { -10, -10, -10 } };
        labels->voxels.assign(27, 0);
        labels->voxels[labels->grid.offset(1, 1, 1)] = 4;
        auto image = std::make_shared<mesh::Volume>();
        image->grid = labels->grid;
        image->voxels.assign(27, 0);
        Scene scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, {});
        scene.cut_away
            = CutAway { .face = SliceItem { .image = image, .plane = SlicePlane::coronal, .labels = labels } };
        check_scene(scene);
        const auto face = pick(scene, { 2.0, -600.0, 3.0 }, Vec3::UnitY());
        ASSERT_TRUE(face);
        EXPECT_EQ(face->label, 4);
        EXPECT_NEAR((face->place - Vec3(2.0, 0.0, 3.0)).norm(), 0.0, kRoundOff);
        const auto beside = pick(scene, { 8.0, -600.0, 3.0 }, Vec3::UnitY());
        ASSERT_TRUE(beside);
        EXPECT_NEAR(beside->place.y(), 50.0, kRoundOff) << "through the hole, to the back of the box";
    }

} // namespace scene_test
} // namespace retractor::ui
