#include "ui/plan_scene/contact_sheet.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "ui/scene/label_colors.h"
#include "ui/scene/vtk/render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::ui {
namespace contact_sheet_test {

    struct Images {
        std::shared_ptr<const mesh::Volume> ct;
        std::shared_ptr<const mesh::LabelVolume> labels;
    };

    Images block_images()
    {
        datasets::BlockParameters parameters;
        parameters.size_mm = { 60.0, 60.0, 60.0 };
        const datasets::Phantom phantom = datasets::make_block_phantom(parameters);
        return { std::make_shared<const mesh::Volume>(phantom.ct),
            std::make_shared<const mesh::LabelVolume>(phantom.labels) };
    }

    std::vector<const Scene*> slices_of(const Picture& picture)
    {
        std::vector<const Scene*> scenes;
        for (const Viewport& viewport : picture.viewports)
            if (!viewport.scene.slices.empty())
                scenes.push_back(&viewport.scene);
        return scenes;
    }

    double difference(const Color& a, const Color& b)
    {
        return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
    }

    TEST(ContactSheet, HasThreePlanesThroughTheWholeBodyAndTheTarget)
    {
        const Images images = block_images();
        ContactSheetOptions options;
        options.focus = Vec3(1.0, 50.0, 3.0);
        const Picture picture = contact_sheet(images.ct, images.labels, options);
        EXPECT_NO_THROW(check_picture(picture));
        const auto slices = slices_of(picture);
        ASSERT_EQ(slices.size(), 15u);
        std::array<int, 3> planes {}, through_focus {};
        for (const Scene* scene : slices) {
            const SliceItem& slice = scene->slices.front();
            const auto plane = static_cast<std::size_t>(slice.plane);
            const int normal = slice.plane == SlicePlane::axial ? 2 : slice.plane == SlicePlane::coronal ? 1 : 0;
            ++planes[plane];
            through_focus[plane] += slice.point[normal] == (*options.focus)[normal] ? 1 : 0;
            EXPECT_EQ(slice.outline_of_label.size(), images.labels->table.size());
        }
        EXPECT_EQ(planes, (std::array { 5, 5, 5 }));
        EXPECT_EQ(through_focus, (std::array { 1, 1, 1 }));
    }

    TEST(ContactSheet, NamesEveryLabelItsVolumeAndWhatIsRough)
    {
        const Images images = block_images();
        ContactSheetOptions options;
        options.rough = { "fat" };
        options.warnings = { "look here" };
        options.notes = { "a note" };
        const Picture picture = contact_sheet(images.ct, images.labels, options);
        const auto has_legend = [](const Viewport& v) { return v.scene.legend.size() > 3; };
        const auto legend = std::find_if(picture.viewports.begin(), picture.viewports.end(), has_legend);
        ASSERT_NE(legend, picture.viewports.end());
        ASSERT_EQ(legend->scene.legend.size(), images.labels->table.size());
        for (const LegendLine& line : legend->scene.legend)
            EXPECT_EQ(line.value.find("rough") != std::string::npos, line.key == "fat") << line.key;
        const Scene& text = picture.viewports.back().scene;
        ASSERT_EQ(text.notes.size(), 2u);
        EXPECT_EQ(text.notes[0], "Look: look here");
        EXPECT_EQ(text.notes[1], "a note");
    }

    TEST(ContactSheet, ManyRibsShareALineAndKeepTheirNumbers)
    {
        auto labels = std::make_shared<mesh::LabelVolume>();
        labels->grid.size = { 130, 4, 4 };
        labels->voxels.resize(labels->grid.voxel_count());
        for (std::size_t v = 0; v < labels->voxels.size(); ++v)
            labels->voxels[v] = static_cast<Label>(v % 130 + 1);
        for (int n = 1; n <= 130; ++n)
            labels->table.push_back({ static_cast<Label>(n),
                n <= 12 ? "rib_left_" + std::to_string(n) : "organ_" + std::to_string(n), "bone", mesh::Role::wall });
        ContactSheetOptions options;
        options.surfaces = false;
        options.columns = 12; // a low sheet: not every label fits
        const Picture picture = contact_sheet(nullptr, labels, options);
        std::size_t rib_lines = 0;
        for (const Viewport& viewport : picture.viewports)
            for (const LegendLine& line : viewport.scene.legend)
                if (line.key.starts_with("left rib")) {
                    ++rib_lines;
                    EXPECT_EQ(line.value, "1 2 3 4 5 6 7 8 9 10 11 12");
                }
        EXPECT_EQ(rib_lines, 1u);
        bool numbered = false;
        for (const Scene* scene : slices_of(picture))
            numbered = numbered || !scene->words.empty();
        EXPECT_TRUE(numbered);
    }

    TEST(ContactSheet, IsDrawnFromAnImageOrLabelsAlone)
    {
        const Images images = block_images();
        OffscreenRenderer renderer(make_offscreen_context());
        ContactSheetOptions options;
        options.width = 1000;
        for (const Picture& picture :
            { contact_sheet(images.ct, nullptr, options), contact_sheet(nullptr, images.labels, options) }) {
            const Image image = renderer.render(picture);
            EXPECT_EQ(image.width, 1000);
            const auto [least, most] = std::minmax_element(image.rgb.begin(), image.rgb.end());
            EXPECT_GT(*most - *least, 100);
        }
    }

    TEST(ContactSheet, RefusesNothingToDrawAndBadOptions)
    {
        const Images images = block_images();
        EXPECT_THROW(contact_sheet(nullptr, nullptr), InputError);
        ContactSheetOptions options;
        options.columns = 0;
        EXPECT_THROW(contact_sheet(images.ct, images.labels, options), InputError);
        options = {};
        options.width = 10;
        EXPECT_THROW(contact_sheet(images.ct, images.labels, options), InputError);
    }

    TEST(LabelColors, NeighboursDifferAndNamesKeepTheirs)
    {
        constexpr double kEasilyTold = 0.4; // of the sum over three channels
        for (const char* side : { "rib_left_", "rib_right_" })
            for (int n = 1; n < 12; ++n)
                EXPECT_GT(difference(label_color(side + std::to_string(n)), label_color(side + std::to_string(n + 1))),
                    kEasilyTold)
                    << side << n;
        EXPECT_GT(difference(label_color("lung_left"), label_color("heart")), kEasilyTold);
        EXPECT_EQ(difference(label_color("spleen"), label_color("spleen")), 0.0);
        EXPECT_EQ(level_of("rib_left_11"), "11");
        EXPECT_EQ(level_of("vertebrae_T7"), "T7");
        EXPECT_EQ(level_of("organ_7"), "");
    }

} // namespace contact_sheet_test
} // namespace retractor::ui
