// Pictures drawn by OSMesa; this program runs with no display.

#include "ui/scene/vtk/render.h"

#include "mesh/base/error.h"
#include "tests/ui/scene/pictures.h"
#include "tests/ui/scene/png_files.h"
#include "tests/ui/scene/sample_scenes.h"
#include "ui/scene/vtk/identifier_picture.h"
#include "ui/scene/vtk/stereo.h"

#include <gtest/gtest.h>


#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

namespace retractor::ui {
namespace render_test {

    using samples::draw;
    using samples::pixel;
    using samples::Pixel;
    using samples::psnr_db;
    using samples::read_png;

    /// Unlit colours come back as given, but for rounding.
    void expect_color(const samples::Pixel& p, int r, int g, int b, int tolerance = 1)
    {
        EXPECT_NEAR(p.r, r, tolerance);
        EXPECT_NEAR(p.g, g, tolerance);
        EXPECT_NEAR(p.b, b, tolerance);
    }

    std::filesystem::path scratch(const std::string& name)
    {
        return std::filesystem::path(testing::TempDir()) / ("retractor_" + name);
    }

    class Pictures : public testing::Test {
    protected:
        void SetUp() override { ::unsetenv("DISPLAY"); }
    };

    TEST_F(Pictures, ABoxIsWhereItShouldBe)
    {
        const Image image = draw(samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, { 1.0, 0.5, 0.0 }));
        EXPECT_EQ(image.width, 320);
        EXPECT_EQ(image.height, 240);
        expect_color(pixel(image, 0.5, 0.5), 255, 128, 0);
        for (const double x : { 0.0, 1.0 })
            for (const double y : { 0.0, 1.0 })
                expect_color(pixel(image, x, y), 0, 0, 0);
        // The front face is 550 mm away: its edge is at 50 / (550 tan 15 deg) of the half height.
        const double edge = 0.5 * 50.0 / (550.0 * std::tan(std::numbers::pi / 12.0));
        constexpr double kTwoPixels = 2.0 / 240.0;
        expect_color(pixel(image, 0.5, 0.5 - edge + kTwoPixels), 255, 128, 0);
        expect_color(pixel(image, 0.5, 0.5 - edge - kTwoPixels), 0, 0, 0);
    }

    TEST_F(Pictures, TheNearBoxHidesTheFarOne)
    {
        for (const bool near_first : { true, false }) {
            const Scene near = samples::box_scene({ -30, -100, -30 }, { 30, -80, 30 }, { 1, 0, 0 });
            Scene scene = samples::box_scene({ -60, 50, -60 }, { 60, 60, 60 }, { 0, 0, 1 });
            scene.surfaces.insert(near_first ? scene.surfaces.begin() : scene.surfaces.end(), near.surfaces[0]);
            const Image image = draw(scene);
            expect_color(pixel(image, 0.5, 0.5), 255, 0, 0);
            expect_color(pixel(image, 0.5, 0.5 - 0.16), 0, 0, 255);
        }
    }

    TEST_F(Pictures, ThePatientsLeftIsOnTheRightFromTheFrontAndTheHeadIsUp)
    {
        Scene scene = samples::box_scene({ 60, -10, -10 }, { 80, 10, 10 }, { 1, 0, 0 }); // left
        scene.surfaces.push_back(
            samples::unlit(samples::box_mesh({ -80, -10, -10 }, { -60, 10, 10 }), { 0, 1, 0 })); // right
        scene.surfaces.push_back(
            samples::unlit(samples::box_mesh({ -10, -10, 60 }, { 10, 10, 80 }), { 0, 0, 1 })); // head
        const Image image = draw(scene, 240, 240);
        const double off = 0.5 * 70.0 / (600.0 * std::tan(std::numbers::pi / 12.0));
        expect_color(pixel(image, 0.5 + off, 0.5), 255, 0, 0);
        expect_color(pixel(image, 0.5 - off, 0.5), 0, 255, 0);
        expect_color(pixel(image, 0.5, 0.5 - off), 0, 0, 255);
        expect_color(pixel(image, 0.5, 0.5 + off), 0, 0, 0);
    }

    TEST_F(Pictures, TrianglesWearTheLookOfTheirLabel)
    {
        Scene scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 0 }, { 1, 1, 1 });
        auto both = std::make_shared<TriMesh>(samples::box_mesh({ -50, -50, -50 }, { 50, 50, 0 }, 1));
        const TriMesh upper = samples::box_mesh({ -50, -50, 0 }, { 50, 50, 50 }, 2);
        const auto first = static_cast<VertexId>(both->vertices.rows());
        Points joined(first + upper.vertices.rows(), 3);
        joined << both->vertices, upper.vertices;
        both->vertices = joined;
        for (const auto& t : upper.triangles)
            both->triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
        both->labels.insert(both->labels.end(), upper.labels.begin(), upper.labels.end());
        scene.surfaces[0].mesh = both;
        scene.surfaces[0].look_of_label = { { 1, { .color = { 0, 1, 0 }, .finish = Finish::unlit } },
            { 2, { .color = { 0, 0, 1 }, .finish = Finish::unlit } } };
        const Image image = draw(scene);
        expect_color(pixel(image, 0.5, 0.45), 0, 0, 255);
        expect_color(pixel(image, 0.5, 0.55), 0, 255, 0);
    }

    TEST_F(Pictures, EveryTissueIsDrawnWithoutShaderErrorsAndKeepsItsHue)
    {
        for (const Finish finish : { Finish::matte, Finish::skin, Finish::wet, Finish::bone, Finish::metal })
            for (const bool target : { false, true }) {
                Scene scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, {});
                scene.surfaces[0].look = { .color = { 0.8, 0.3, 0.2 }, .finish = finish, .texture = 0.7 };
                scene.surfaces[0].target = target;
                const samples::Pixel p = pixel(draw(scene), 0.5, 0.5);
                EXPECT_GT(p.r, 60);
                if (finish != Finish::metal) {
                    EXPECT_GT(p.r, p.g + 20);
                }
            }
    }

    /// A cube of contrast-filled tissue, 60 mm wide, centred at the origin.
    std::shared_ptr<const mesh::Volume> cube(std::int16_t shell, std::int16_t core)
    {
        auto volume = std::make_shared<mesh::Volume>();
        volume->grid = { .size = { 40, 40, 40 }, .spacing = { 2, 2, 2 }, .origin = { -39, -39, -39 } };
        for (int k = 0; k < 40; ++k)
            for (int j = 0; j < 40; ++j)
                for (int i = 0; i < 40; ++i) {
                    const double r = volume->grid.world(Vec3(i, j, k)).cwiseAbs().maxCoeff();
                    volume->voxels.push_back(r < 16.0 ? core : r < 30.0 ? shell : static_cast<std::int16_t>(-1000));
                }
        return volume;
    }

    Scene volume_scene(std::shared_ptr<const mesh::Volume> image)
    {
        Scene scene = samples::box_scene({ 0, 0, 0 }, { 1, 1, 1 }, {});
        scene.surfaces.clear();
        VolumeItem item;
        item.image = std::move(image);
        scene.volumes.push_back(std::move(item));
        scene.camera.eye = { 0, -400, 0 };
        return scene;
    }

    TEST_F(Pictures, APlateInFrontOfAVolumeHidesItAndOneBehindDoesNot)
    {
        const TriMesh front = samples::box_mesh({ -60, -55, -60 }, { 60, -50, 60 });
        const TriMesh inside = samples::box_mesh({ -60, 0, -60 }, { 60, 2, 60 });
        const auto shown = [&](const TriMesh& plate) {
            Scene scene = volume_scene(cube(250, 250));
            scene.surfaces.push_back(samples::unlit(plate, { 0, 0, 1 }));
            return draw(scene);
        };
        const Image hidden = shown(front), seen = shown(inside);
        expect_color(pixel(hidden, 0.5, 0.5), 0, 0, 255);
        EXPECT_GT(pixel(seen, 0.5, 0.5).r, 90); // blood in front of the plate
        EXPECT_LT(pixel(seen, 0.5, 0.5).b, 90);
        expect_color(
            pixel(seen, 0.5, 0.5 - 0.5 * 45.0 / (400.0 * std::tan(std::numbers::pi / 12.0))), 0, 0, 255); // beside it
    }

    TEST_F(Pictures, WhatIsCutAwayShowsTheInsideAndTheImageOnTheCut)
    {
        Scene scene = samples::box_scene({ -60, -60, -60 }, { 60, 60, 60 }, { 1, 0, 0 });
        scene.surfaces.push_back(samples::unlit(samples::box_mesh({ -20, 20, -20 }, { 20, 40, 20 }), { 0, 0, 1 }));
        expect_color(pixel(draw(scene), 0.5, 0.5), 255, 0, 0);
        scene.cut_away = CutAway {}; // everything in front of y = 0
        Image image = draw(scene);
        expect_color(pixel(image, 0.5, 0.5), 0, 0, 255);
        expect_color(pixel(image, 0.5, 0.4), 255, 0, 0); // the back of the box, beside the inner one
        scene.cut_away->kept = -Vec3::UnitY();
        expect_color(pixel(draw(scene), 0.5, 0.5), 255, 0, 0);

        // The image on the cut: grey where there are labels, nothing elsewhere.
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid = { .size = { 12, 12, 12 }, .spacing = { 10, 10, 10 }, .origin = { -55, -55, -55 } };
        auto ct = std::make_shared<mesh::Volume>();
        ct->grid = labels->grid;
        ct->voxels.assign(labels->grid.voxel_count(), 40);
        for (int k = 0; k < 12; ++k)
            for (int j = 0; j < 12; ++j)
                for (int i = 0; i < 12; ++i)
                    labels->voxels.push_back(i < 6 ? 1 : 0);
        scene.cut_away = CutAway { .face
            = SliceItem {
                .image = ct, .plane = SlicePlane::coronal, .window_hu = 200.0, .level_hu = 40.0, .labels = labels } };
        image = draw(scene);
        constexpr int kMiddleGrey = 128, kInterpolated = 3;
        expect_color(pixel(image, 0.45, 0.5), kMiddleGrey, kMiddleGrey, kMiddleGrey, kInterpolated);
        expect_color(pixel(image, 0.53, 0.5), 0, 0, 255);
    }

    TEST_F(Pictures, AHiddenShellRevealsTheInside)
    {
        const auto image = cube(250, 1500); // blood round bone
        auto mask = std::make_shared<VoxelMask>();
        mask->grid = image->grid;
        for (const auto hu : image->voxels)
            mask->hidden.push_back(hu == 250 ? 1 : 0);
        Scene scene = volume_scene(image);
        const samples::Pixel closed = pixel(draw(scene), 0.5, 0.5);
        scene.volumes[0].mask = mask;
        const Image open = draw(scene);
        const samples::Pixel core = pixel(open, 0.5, 0.5);
        EXPECT_GT(closed.r, closed.b + 60); // red
        EXPECT_NEAR(core.r, core.b, 60); // ivory
        EXPECT_GT(core.b, closed.b + 60);
        // Nothing is left of the shell, not even a haze at its rim.
        for (const double mm : { 20.0, 24.0, 28.0, 30.0, 32.0 })
            expect_color(pixel(open, 0.5, 0.5 - 0.5 * mm / (375.0 * std::tan(std::numbers::pi / 12.0))), 0, 0, 0, 3);
    }

    TEST_F(Pictures, AVolumeOnMirroredTurnedAxesIsDrawnWhereItLies)
    {
        // A block of blood on the patient's left of the image, with the grid's axes permuted and mirrored.
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 30, 40, 50 }, .spacing = { 2, 2, 2 } };
        image->grid.direction << 0, -1, 0, 0, 0, 1, 1, 0, 0; // i up, j to the right, k to the back: det < 0
        ASSERT_LT(image->grid.direction.determinant(), 0.0);
        image->grid.origin = -image->grid.direction * Vec3(29, 39, 49);
        for (int k = 0; k < 50; ++k)
            for (int j = 0; j < 40; ++j)
                for (int i = 0; i < 30; ++i) {
                    const Vec3 p = image->grid.world(Vec3(i, j, k));
                    const bool inside
                        = p.x() > 10 && p.x() < 30 && p.z() > 5 && p.z() < 25 && p.y() < -20 && p.y() > -40;
                    image->voxels.push_back(inside ? 250 : -1000);
                }
        const Image picture = draw(volume_scene(image), 240, 240);
        const double scale = 0.5 / (370.0 * std::tan(std::numbers::pi / 12.0));
        EXPECT_GT(pixel(picture, 0.5 + 20 * scale, 0.5 - 15 * scale).r, 80);
        expect_color(pixel(picture, 0.5 - 20 * scale, 0.5 - 15 * scale), 0, 0, 0);
        expect_color(pixel(picture, 0.5 + 20 * scale, 0.5 + 15 * scale), 0, 0, 0);
        expect_color(pixel(picture, 0.5 - 20 * scale, 0.5 + 15 * scale), 0, 0, 0);
    }

    TEST_F(Pictures, SlicesShowTheImageWithTheLeftOnTheRight)
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 40, 40, 40 }, .spacing = { 2, 2, 2 }, .origin = { -39, -39, -39 } };
        for (int k = 0; k < 40; ++k)
            for (int j = 0; j < 40; ++j)
                for (int i = 0; i < 40; ++i) // bright in the left, front, upper eighth
                    image->voxels.push_back(i >= 20 && j < 20 && k >= 20 ? 1000 : -1000);
        // Where the bright quarter of each plane is in its picture: across, down.
        const std::array<std::pair<SlicePlane, std::array<double, 2>>, 3> cases { { { SlicePlane::axial, { 0.7, 0.3 } },
            { SlicePlane::coronal, { 0.7, 0.3 } }, { SlicePlane::sagittal, { 0.3, 0.3 } } } };
        for (const auto& [plane, bright] : cases) {
            Scene scene = samples::box_scene({ 0, 0, 0 }, { 1, 1, 1 }, {});
            scene.surfaces.clear();
            scene.slices.push_back({ .image = image, .plane = plane, .point = { 20, -20, 20 } });
            scene.camera = camera_for_slice(scene.slices[0], 1.0);
            const Image picture = draw(scene, 200, 200);
            for (const double x : { 0.3, 0.7 })
                for (const double y : { 0.3, 0.7 })
                    EXPECT_EQ(pixel(picture, x, y).r, x == bright[0] && y == bright[1] ? 255 : 0)
                        << static_cast<int>(plane) << ' ' << x << ' ' << y;
        }
    }

    TEST_F(Pictures, ALineOnTopIsDrawnOverWhatIsInFrontOfIt)
    {
        for (const bool on_top : { true, false }) {
            Scene scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, { 1, 0, 0 });
            scene.lines.push_back({ .name = "line",
                .points = { { -40, 0, 0 }, { 40, 0, 0 } },
                .color = { 0, 1, 0 },
                .width_px = 24.0,
                .on_top = on_top });
            const samples::Pixel p = pixel(draw(scene), 0.5, 0.5);
            EXPECT_EQ(p.g > 200, on_top);
        }
    }

    /// Pixels that two pictures do not share, within a rectangle of fractions (left, top, right, bottom).
    int different(const Image& a, const Image& b, const std::array<double, 4>& where)
    {
        int count = 0;
        for (int y = static_cast<int>(where[1] * a.height); y < static_cast<int>(where[3] * a.height); ++y)
            for (int x = static_cast<int>(where[0] * a.width); x < static_cast<int>(where[2] * a.width); ++x) {
                const std::size_t first = 3 * static_cast<std::size_t>(y * a.width + x);
                count += std::abs(a.rgb[first] - b.rgb[first]) > 60 ? 1 : 0;
            }
        return count;
    }

    TEST_F(Pictures, TitleLegendScaleBarAndMarkerAppearInTheirCorners)
    {
        const std::array<double, 4> upper_left { 0.0, 0.0, 0.5, 0.5 }, lower_left { 0.0, 0.7, 0.5, 1.0 },
            lower_right { 0.8, 0.8, 1.0, 1.0 }, middle { 0.5, 0.0, 1.0, 0.75 };
        const Scene plain = samples::box_scene({ -1, -1, -1 }, { 1, 1, 1 }, { 0, 0, 0 });
        const Image nothing = draw(plain, 640, 480);
        Scene scene = plain;
        scene.title = "Title";
        scene.legend = { { "visible", "87 %" } };
        const Image words = draw(scene, 640, 480);
        EXPECT_GT(different(words, nothing, upper_left), 250);
        scene = plain;
        scene.scale_bar = true;
        EXPECT_GT(different(draw(scene, 640, 480), nothing, lower_left), 100);
        scene = plain;
        scene.orientation_marker = true;
        EXPECT_GT(different(draw(scene, 640, 480), nothing, lower_right), 200);
        scene.scale_bar = true;
        scene.title = "Title";
        EXPECT_EQ(different(draw(scene, 640, 480), nothing, middle), 0);
    }

    TEST_F(Pictures, LegendLettersAreBrightOnTheirPanel)
    {
        Scene scene = samples::box_scene({ -300, 0, -300 }, { 300, 10, 300 }, { 0.5, 0.5, 0.5 });
        scene.legend = { { "visible target", "87 %" }, { "hook force", "42 N" } };
        const Image image = draw(scene, 640, 480);
        int bright = 0;
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 320; ++x)
                bright += image.rgb[3 * static_cast<std::size_t>(y * image.width + x)] > 180 ? 1 : 0;
        EXPECT_GT(bright, 150);
    }

    TEST_F(Pictures, ALongLegendStaysInsideANarrowView)
    {
        Scene scene = samples::box_scene({ -1, -1, -1 }, { 1, 1, 1 }, { 0, 0, 0 });
        for (int i = 0; i < 12; ++i)
            scene.legend.push_back({ "a rather long name of a measure " + std::to_string(i), "123.45 mm" });
        const Image image = draw(scene, 300, 480);
        for (int y = 0; y < image.height; ++y)
            for (const int x : { 0, 298, 299 })
                EXPECT_LT(image.rgb[3 * static_cast<std::size_t>(y * image.width + x)], 30);
    }

    TEST_F(Pictures, ViewsSideBySideKeepToThemselves)
    {
        Picture picture { .width = 300, .height = 100, .viewports = {} };
        const std::array<Color, 3> colors { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
        for (std::size_t i = 0; i < 3; ++i)
            picture.viewports.push_back({ .left = static_cast<double>(i) / 3.0,
                .right = static_cast<double>(i + 1) / 3.0,
                .scene = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, colors[i]) });
        const Image image = samples::renderer().render(picture);
        expect_color(pixel(image, 1.0 / 6.0, 0.5), 255, 0, 0);
        expect_color(pixel(image, 3.0 / 6.0, 0.5), 0, 255, 0);
        expect_color(pixel(image, 5.0 / 6.0, 0.5), 0, 0, 255);
        expect_color(pixel(image, 1.0 / 3.0, 0.05), 0, 0, 0);
    }

    TEST_F(Pictures, ScenesThatAreKeptAreDrawnFromOtherPlacesAsNewOnesWouldBe)
    {
        Picture picture { .width = 320, .height = 240, .viewports = {} };
        picture.viewports.emplace_back();
        picture.viewports[0].scene = samples::little_chest(false);
        OffscreenRenderer& renderer = samples::renderer();
        renderer.show(picture);
        Camera camera = picture.viewports[0].scene.camera;
        const Image first = renderer.draw({ camera });
        camera.eye += Vec3(60.0, 10.0, 40.0);
        const Image turned = renderer.draw({ camera });
        EXPECT_NE(first.rgb, turned.rgb);
        EXPECT_EQ(first.rgb, renderer.render(picture).rgb);
        picture.viewports[0].scene.camera = camera;
        EXPECT_EQ(turned.rgb, renderer.render(picture).rgb);
    }

    TEST_F(Pictures, TheSameSceneGivesTheSamePicture)
    {
        const Scene scene = samples::little_chest();
        const Image first = draw(scene);
        draw(samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, { 1, 0, 0 })); // something else in between
        EXPECT_EQ(first.rgb, draw(scene).rgb);
    }

    // The share of the target that a view shows.

    TEST_F(Pictures, TargetShareOfASphereHalfBehindAPlateIsOneHalf)
    {
        Scene scene;
        SurfaceItem sphere = samples::unlit(samples::sphere_mesh({ 0, 0, 0 }, 30.0), { 1, 1, 0 });
        sphere.target = true;
        scene.surfaces
            = { sphere, samples::unlit(samples::box_mesh({ -100, -60, -100 }, { 0, -50, 100 }), { 1, 0, 0 }) };
        scene.camera.eye = { 0, -400, 0 };
        const TargetPixels pixels = target_pixels(samples::renderer(), scene, 640);
        // The sphere's outline is a circle, and the picture is 1.05 times as high as it.
        const double radius = 320.0 / 1.05;
        const double area = std::numbers::pi * radius * radius;
        constexpr double kPolygon = 0.005; // the sphere's 96 sides and its outline's pixels
        EXPECT_NEAR(static_cast<double>(pixels.alone) / area, 1.0, kPolygon);
        EXPECT_NEAR(pixels.share(), 0.5, kPolygon);
        scene.surfaces[1].on_top = true;
        EXPECT_DOUBLE_EQ(target_pixels(samples::renderer(), scene, 640).share(), 1.0);
        scene.surfaces.resize(1);
        scene.surfaces[0].target = false;
        EXPECT_DOUBLE_EQ(target_pixels(samples::renderer(), scene, 640).share(), 0.0);
    }

    TEST_F(Pictures, TargetShareIgnoresVolumesLinesAndWords)
    {
        Scene scene = samples::little_chest(false);
        const TargetPixels bare = target_pixels(samples::renderer(), scene, 320);
        scene = samples::little_chest(true);
        const TargetPixels full = target_pixels(samples::renderer(), scene, 320);
        EXPECT_GT(bare.alone, 100U);
        EXPECT_EQ(bare.visible, full.visible);
        EXPECT_EQ(bare.alone, full.alone);
    }

    TEST_F(Pictures, EveryPixelKnowsItsStructure)
    {
        // A box with two labels behind a smaller box, and one that is drawn on top and so hides nothing.
        Scene scene = samples::box_scene({ -20, -60, -20 }, { 20, -50, 20 }, { 0.3, 0.2, 0.9 });
        scene.surfaces[0].name = "aorta";
        SurfaceItem wall = samples::unlit(samples::box_mesh({ -80, 0, -80 }, { 80, 10, 80 }, 3), { 1, 1, 1 });
        wall.name = "wall";
        wall.look_of_label = { { 3, wall.look }, { 4, wall.look } };
        scene.surfaces.push_back(wall);
        SurfaceItem glow = samples::unlit(samples::box_mesh({ -80, -90, -80 }, { 80, -80, 80 }), { 1, 1, 1 });
        glow.on_top = true;
        scene.surfaces.push_back(glow);
        scene.camera.eye = { 0, -400, 0 };
        scene.camera.aim = { 0, 0, 0 };
        constexpr int kSize = 200;
        const IdentifierPicture picture
            = identifier_picture(samples::renderer(), scene, { { 3, "sternum" } }, kSize, kSize);
        ASSERT_EQ(picture.structure.size(), static_cast<std::size_t>(kSize * kSize));
        const auto name_at = [&](int x, int y) {
            const int structure = picture.structure[static_cast<std::size_t>(y * kSize + x)];
            return structure < 0 ? std::string() : picture.names[static_cast<std::size_t>(structure)];
        };
        EXPECT_EQ(name_at(kSize / 2, kSize / 2), "aorta");
        EXPECT_EQ(name_at(kSize / 2, kSize * 3 / 4), "sternum");
        EXPECT_EQ(name_at(1, 1), "");

        Scene crowded = scene;
        crowded.legend.assign(26, { "line", "1 mm" }); // a legend over the left of the picture
        crowded.legend_share = 0.6;
        add_names(crowded, picture);
        for (const TextItem& word : crowded.words)
            EXPECT_GT(word.position.x(), 0.2 * 20.0) << word.text << " lies under the legend";
        add_names(scene, picture);
        ASSERT_EQ(scene.words.size(), 2U);
        for (const TextItem& word : scene.words) {
            const Vec3 at = word.position; // in the plane of the aim
            EXPECT_NEAR(at.y(), 0.0, 1e-9);
            const bool in_front = std::abs(at.x()) < 20.0 * 400.0 / 340.0 && std::abs(at.z()) < 20.0 * 400.0 / 340.0;
            EXPECT_EQ(word.text, in_front ? "aorta" : "sternum");
        }
    }

    // Bookkeeping, files and failures.

    TEST_F(Pictures, PartsAreRecordedWhenTheyAreBuilt)
    {
        Ledger ledger;
        OffscreenRenderer own(make_offscreen_context(), { .on_progress = {}, .cancel = nullptr, .ledger = &ledger });
        EXPECT_TRUE(ledger.has("renderer"));
        Picture picture { .width = 64, .height = 48, .viewports = {} };
        picture.viewports.push_back({ .scene = samples::little_chest(false) });
        own.render(picture);
        EXPECT_FALSE(ledger.has("volume rendering"));
        picture.viewports[0].scene = volume_scene(cube(250, 250));
        own.render(picture);
        own.render(picture);
        const auto parts = ledger.parts();
        EXPECT_EQ(
            std::count_if(parts.begin(), parts.end(), [](const BuiltPart& p) { return p.name == "volume rendering"; }),
            1);
    }

    TEST_F(Pictures, OnlyWhatCanShowOfAVolumeIsPreparedAndOnceForEqualMasks)
    {
        Ledger ledger;
        OffscreenRenderer own(make_offscreen_context(), { .on_progress = {}, .cancel = nullptr, .ledger = &ledger });
        // A little block of blood in a big image of air, and a hidden block of blood far from it.
        auto image = std::make_shared<mesh::Volume>();
        image->grid = { .size = { 60, 50, 40 } };
        image->grid.origin = { -30, -25, -20 };
        image->voxels.assign(image->grid.voxel_count(), -1000);
        auto mask = std::make_shared<VoxelMask>();
        mask->grid = image->grid;
        mask->hidden.assign(image->voxels.size(), 0);
        for (int k = 15; k < 25; ++k)
            for (int j = 15; j < 25; ++j)
                for (int i = 10; i < 20; ++i) {
                    image->voxels[image->grid.offset(i, j, k)] = 250;
                    image->voxels[image->grid.offset(i + 35, j, k)] = 250;
                    mask->hidden[image->grid.offset(i + 35, j, k)] = 1;
                }
        Picture picture { .width = 64, .height = 48, .viewports = {} };
        picture.viewports.push_back({ .scene = volume_scene(image) });
        picture.viewports[0].scene.volumes[0].mask = mask;
        const Image first = own.render(picture);
        picture.viewports[0].scene.volumes[0].mask = std::make_shared<VoxelMask>(*mask);
        EXPECT_EQ(own.render(picture).rgb, first.rgb);
        const auto parts = ledger.parts();
        const auto is_volume = [](const BuiltPart& p) { return p.name == "volume rendering"; };
        ASSERT_EQ(std::count_if(parts.begin(), parts.end(), is_volume), 1);
        constexpr std::size_t kWithMargin = 16 * 16 * 16; // three voxels round the block
        EXPECT_LE(std::find_if(parts.begin(), parts.end(), is_volume)->bytes, 2 * kWithMargin * sizeof(std::int16_t));
    }

    TEST_F(Pictures, APngComesBackAsItWasWritten)
    {
        const Image image = draw(samples::little_chest(false), 160, 120);
        const auto path = scratch("picture.png");
        write_png(path, image);
        const Image back = read_png(path);
        EXPECT_EQ(back.width, 160);
        EXPECT_EQ(back.height, 120);
        EXPECT_EQ(back.rgb, image.rgb);
        EXPECT_TRUE(std::isinf(psnr_db(image, back)));
        std::filesystem::remove(path);
    }

    TEST(Psnr, IsTheClosedForm)
    {
        const Image black { .width = 2, .height = 1, .rgb = { 0, 0, 0, 0, 0, 0 } };
        const Image grey { .width = 2, .height = 1, .rgb = { 51, 51, 51, 51, 51, 51 } };
        EXPECT_NEAR(psnr_db(black, grey), 20.0 * std::log10(5.0), 1e-12);
        EXPECT_THROW(psnr_db(black, Image { .width = 1, .height = 1, .rgb = { 0, 0, 0 } }), InputError);
    }

    TEST(Png, RefusesEmptyImagesBadFoldersAndOtherFiles)
    {
        EXPECT_THROW(write_png(scratch("empty.png"), Image {}), InputError);
        const Image dot { .width = 1, .height = 1, .rgb = { 1, 2, 3 } };
        EXPECT_THROW(write_png("/no/such/folder/picture.png", dot), IoError);
        EXPECT_THROW(read_png(scratch("missing.png")), IoError);
        const auto path = scratch("no.png");
        std::ofstream(path) << "this is text";
        EXPECT_THROW(read_png(path), IoError);
        std::filesystem::remove(path);
    }

    /// Mean column of the pixels in which a channel is bright, among those that belong to an eye; the picture has
    /// nothing else that is bright.
    template <class Belongs> double middle_of(const Image& image, int channel, const Belongs& belongs)
    {
        constexpr int kBright = 60;
        const auto width = static_cast<std::size_t>(image.width);
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < image.rgb.size() / 3; ++i)
            if (image.rgb[3 * i + static_cast<std::size_t>(channel)] > kBright && belongs(i % width, i / width)) {
                sum += static_cast<double>(i % width);
                ++count;
            }
        EXPECT_GT(count, 0);
        return sum / std::max(count, 1);
    }

    double middle_of(const Image& image, int channel)
    {
        return middle_of(image, channel, [](std::size_t, std::size_t) { return true; });
    }

    constexpr int kWideForEyes = 640, kHighForEyes = 480;

    /// A white plate on the line of sight, so much nearer than what the camera aims at from 400 mm.
    Image plate_for_eyes(double towards_eye_mm)
    {
        Scene scene = samples::box_scene({ -1, -1, -1 }, { 1, 1, 1 }, { 1.0, 1.0, 1.0 });
        scene.camera.eye = Vec3(0.0, -400.0, 0.0);
        scene.camera.aim = Vec3::Zero();
        const Vec3 middle(0.0, -towards_eye_mm, 0.0), half(5.0, 0.5, 5.0); // a plate: one distance
        scene.surfaces = { samples::unlit(samples::box_mesh(middle - half, middle + half), { 1.0, 1.0, 1.0 }) };
        return draw(scene, kWideForEyes, kHighForEyes);
    }

    /// Pixels by which the left eye should see such a plate farther right than the right eye. An eye at x sees a point
    /// d before the plane of the screen, which is D away, at -x d / (D - d) in this plane.
    double expected_apart(double d)
    {
        const double pixels_per_mm
            = kHighForEyes / (2.0 * 400.0 * std::tan(0.5 * Scene {}.camera.view_angle_deg * std::numbers::pi / 180.0));
        return pixels_per_mm * kEyesApartShare * 400.0 * d / (400.0 - d);
    }

    TEST_F(Pictures, ThreeDMonitorsGetThePicturesOfBothEyes)
    {
        constexpr int kRed = 0;
        constexpr double kPixel = 1.0; // of the picture before it is made half as wide
        for (const double towards_eye : { 100.0, 0.0, -100.0 }) {
            samples::renderer().set_stereo(Stereo::side_by_side);
            const Image halves = plate_for_eyes(towards_eye);
            samples::renderer().set_stereo(Stereo::lines);
            const Image lines = plate_for_eyes(towards_eye);
            samples::renderer().set_stereo(Stereo::off);
            constexpr std::size_t kHalf = kWideForEyes / 2;
            const double left_half
                = middle_of(halves, kRed, [](std::size_t column, std::size_t) { return column < kHalf; });
            const double right_half
                = middle_of(halves, kRed, [](std::size_t column, std::size_t) { return column >= kHalf; });
            EXPECT_NEAR(2.0 * (left_half - (right_half - kHalf)), expected_apart(towards_eye), 2.0 * kPixel);
            const double even = middle_of(lines, kRed, [](std::size_t, std::size_t row) { return row % 2 == 0; });
            const double odd = middle_of(lines, kRed, [](std::size_t, std::size_t row) { return row % 2 == 1; });
            EXPECT_NEAR(odd - even, expected_apart(towards_eye), kPixel) << "the top line is the right eye's";
        }
    }

    TEST_F(Pictures, TwoEyesSeeWhatIsNearAndFarAsTheyShould)
    {
        constexpr int kRed = 0, kBlue = 2;
        constexpr double kPixel = 1.0; // a plate some 20 pixels wide has its middle to less
        const auto apart = [&](double towards_eye_mm) {
            const Image image = plate_for_eyes(towards_eye_mm);
            return middle_of(image, kRed) - middle_of(image, kBlue);
        };
        EXPECT_NEAR(apart(100.0), 0.0, 1e-9) << "one eye";
        samples::renderer().set_stereo(Stereo::red_cyan);
        const double near = apart(100.0), at_screen = apart(0.0), far = apart(-100.0);
        samples::renderer().set_stereo(Stereo::off);
        EXPECT_NEAR(near, expected_apart(100.0), kPixel) << "the left eye, behind the red glass, sees it further right";
        EXPECT_NEAR(at_screen, 0.0, kPixel);
        EXPECT_NEAR(far, expected_apart(-100.0), kPixel);
        EXPECT_NEAR(apart(100.0), 0.0, 1e-9) << "one eye again";
    }

    TEST_F(Pictures, WhatCannotBeDrawnIsRefusedAndTheRendererGoesOn)
    {
        Scene bad = samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, { 1, 0, 0 });
        bad.camera.eye = bad.camera.aim;
        EXPECT_THROW(draw(bad), InputError);
        EXPECT_THROW(draw(samples::little_chest(false), 0, 100), InputError);
        EXPECT_THROW(OffscreenRenderer(nullptr), InputError);
        expect_color(
            pixel(draw(samples::box_scene({ -50, -50, -50 }, { 50, 50, 50 }, { 1, 0, 0 })), 0.5, 0.5), 255, 0, 0);
    }

} // namespace render_test
} // namespace retractor::ui
