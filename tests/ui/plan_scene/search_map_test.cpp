#include "ui/plan_scene/search_map.h"

#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui {
namespace search_map_test {

    constexpr int kWidth = 900, kHeight = 450;

    class SearchMap : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
            patient = std::make_unique<planner::Patient>(test_support::block_case("search_map", phantom));
        }
        static void TearDownTestSuite() { patient.reset(); }

        /// A place in the middle of a triangle of the body, so that the map must colour it.
        static Vec3 on_body(std::size_t triangle)
        {
            const auto body = patient->body();
            const auto corners = triangle_corners(body->vertices, body->triangles[triangle]);
            return (corners[0] + corners[1] + corners[2]) / 3.0;
        }

        /// The triangle whose middle lies farthest from a place.
        static std::size_t farthest_from(const Vec3& place)
        {
            std::size_t farthest = 0;
            for (std::size_t t = 1; t < patient->body()->triangles.size(); ++t)
                if ((on_body(t) - place).norm() > (on_body(farthest) - place).norm())
                    farthest = t;
            return farthest;
        }

        using Numbers = std::array<double, 3>; // red, green, blue
        static Numbers numbers_of(const Color& color) { return { color.r, color.g, color.b }; }

        static Numbers color_at(const Picture& picture, std::size_t triangle)
        {
            const SurfaceItem& skin = picture.viewports.front().scene.surfaces.front();
            return numbers_of(skin.look_of_label.at(skin.mesh->labels[triangle]).color);
        }

        static Numbers legend_color(const Picture& picture, const std::string& text)
        {
            const std::vector<LegendLine>& legend = picture.viewports.back().scene.legend;
            const auto line = std::ranges::find(legend, text, &LegendLine::key);
            const bool found = line != legend.end() && line->swatch.has_value();
            EXPECT_TRUE(found) << text;
            return found ? numbers_of(*line->swatch) : Numbers {};
        }

        static inline std::unique_ptr<planner::Patient> patient;
    };

    TEST_F(SearchMap, APlaceThatShowsTooLittleHasNoScore)
    {
        const std::size_t here = 0, there = farthest_from(on_body(0));
        planner::IncisionSearch search;
        search.tried = { { .middle = on_body(here), .points_of_100 = 70.0, .shows_little = true },
            { .middle = on_body(there), .points_of_100 = 30.0 } };
        const Picture picture = search_map(*patient, search, {}, kWidth, kHeight);
        EXPECT_EQ(color_at(picture, here), legend_color(picture, "shows too little for a proposal"));
        EXPECT_EQ(color_at(picture, there), legend_color(picture, "30 to 31"))
            << "the scores in the legend are those of the places that can be proposed";
        // Another incision with its middle there shows enough.
        search.tried.push_back({ .middle = on_body(here), .points_of_100 = 30.0 });
        EXPECT_EQ(color_at(search_map(*patient, search, {}, kWidth, kHeight), here), color_at(picture, there));
    }

    TEST_F(SearchMap, ASternotomyIsColouredAlongItsLength)
    {
        const std::size_t top = 0, bottom = farthest_from(on_body(0));
        planner::FoundIncision sternum;
        sternum.kind = planner::FoundIncision::Kind::sternum;
        sternum.points = { on_body(top), on_body(bottom) };
        sternum.points_of_100 = 40.0;
        planner::IncisionSearch search;
        search.found = { sternum };
        search.tried = { { .middle = 0.5 * (on_body(top) + on_body(bottom)), .points_of_100 = 40.0 } };
        const Picture picture = search_map(*patient, search, {}, kWidth, kHeight);
        EXPECT_EQ(color_at(picture, top), legend_color(picture, "40 to 41"));
        EXPECT_EQ(color_at(picture, bottom), legend_color(picture, "40 to 41"));
    }

    TEST_F(SearchMap, WithoutAScoreTheLegendHasNone)
    {
        planner::IncisionSearch search;
        search.tried = { { .middle = on_body(0), .points_of_100 = 70.0, .near_risk = true } };
        const Picture picture = search_map(*patient, search, {}, kWidth, kHeight);
        EXPECT_EQ(color_at(picture, 0), legend_color(picture, "too near a structure at risk"));
        EXPECT_TRUE(std::ranges::none_of(picture.viewports.back().scene.legend,
            [](const LegendLine& line) { return line.key.find("score") != std::string::npos; }));
        search.tried.clear();
        EXPECT_THROW(search_map(*patient, search, {}, kWidth, kHeight), InputError);
    }

} // namespace search_map_test
} // namespace retractor::ui
