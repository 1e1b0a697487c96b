#include "ui/report_view/field_view.h"

#include "mesh/base/base64.h"
#include "planner/case/case_io.h"
#include "planner/measures/report/report.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "ui/plan_scene/plan_scene.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace retractor::ui {
namespace field_view_test {

    using Json = nlohmann::ordered_json;

    std::string decoded(const std::string& text)
    {
        const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string bytes;
        unsigned bits = 0;
        int count = 0;
        for (const char c : text) {
            if (c == '=')
                break;
            bits = bits << 6U | static_cast<unsigned>(alphabet.find(c));
            if ((count += 6) >= 8)
                bytes += static_cast<char>(bits >> static_cast<unsigned>(count -= 8) & 0xFFU);
        }
        return bytes;
    }

    template <class Number> std::vector<Number> numbers(const Json& text)
    {
        const std::string bytes = decoded(text.get<std::string>());
        EXPECT_EQ(bytes.size() % sizeof(Number), 0U);
        std::vector<Number> values(bytes.size() / sizeof(Number));
        std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Number));
        return values;
    }

    std::string content(const std::filesystem::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    TEST(Base64, IsThatOfTheStandard)
    {
        EXPECT_EQ(base64(""), "");
        EXPECT_EQ(base64("f"), "Zg==");
        EXPECT_EQ(base64("fo"), "Zm8=");
        EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
        EXPECT_EQ(decoded(base64(std::string("\0\xff\x7f", 3))), std::string("\0\xff\x7f", 3));
    }

    class FieldView : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
            patient = std::make_unique<planner::Patient>(test_support::block_case("view", phantom));
            field = std::make_unique<planner::PlannedField>(planner::plan_approach(
                *patient, test_support::block_approach(*patient->labels(), Eigen::Isometry3d::Identity(), 16.0)));
            text = field_view(*patient, *field);
            view = Json::parse(text);
        }
        static void TearDownTestSuite()
        {
            field.reset();
            patient.reset();
        }
        /// Positions in mm.
        static std::vector<Vec3> positions(const Json& steps)
        {
            const auto vec = [](const Json& json) { return Vec3(json.at(0), json.at(1), json.at(2)); };
            const Vec3 low = vec(view.at("box").at("low")), high = vec(view.at("box").at("high"));
            const std::vector<std::uint16_t> values = numbers<std::uint16_t>(steps);
            std::vector<Vec3> points;
            for (std::size_t n = 0; n + 2 < values.size(); n += 3)
                points.emplace_back(
                    low + Vec3(values[n], values[n + 1], values[n + 2]).cwiseProduct(high - low) / 65535.0);
            return points;
        }
        static inline std::unique_ptr<planner::Patient> patient;
        static inline std::unique_ptr<planner::PlannedField> field;
        static inline std::string text;
        static inline Json view;
    };

    /// Largest motion of a drawn vertex, mm.
    double largest_motion(const TriMesh& opened, const TriMesh& rest)
    {
        double largest = 0.0;
        for (const auto& triangle : opened.triangles)
            for (const VertexId v : triangle)
                largest = std::max(largest, (opened.vertices.row(v) - rest.vertices.row(v)).norm());
        return largest;
    }

    TEST_F(FieldView, HoldsTheWallAtRestAndOpened)
    {
        const TriMesh opened = drawn_wall(*patient, *field, field->opening.displacement);
        const TriMesh beyond = remaining_wall_at_rest(*patient, *field);
        ASSERT_EQ(beyond.triangles, field->remaining_wall.triangles);
        std::size_t triangles = 0;
        double largest = 0.0;
        for (const Json& surface : view.at("surfaces")) {
            const std::vector<std::uint32_t> corners = numbers<std::uint32_t>(surface.at("triangles"));
            const std::vector<Vec3> to = positions(surface.at("opened"));
            for (const std::uint32_t corner : corners)
                ASSERT_LT(corner, to.size());
            if (!surface.contains("rest"))
                continue;
            triangles += corners.size() / 3;
            const std::vector<Vec3> from = positions(surface.at("rest"));
            ASSERT_EQ(from.size(), to.size());
            for (std::size_t n = 0; n < from.size(); ++n)
                largest = std::max(largest, (to[n] - from[n]).norm());
        }
        EXPECT_EQ(triangles, opened.triangles.size() + beyond.triangles.size());
        constexpr double kStepMm = 0.01; // of 16 bits over this small box, with a margin
        EXPECT_NEAR(largest,
            std::max(largest_motion(opened, drawn_wall(*patient, *field, {})),
                largest_motion(field->remaining_wall, beyond)),
            kStepMm);
    }

    TEST_F(FieldView, HasLayersAndCameras)
    {
        std::vector<std::string> layers;
        for (const Json& layer : view.at("layers"))
            layers.push_back(layer.at("key"));
        EXPECT_EQ(layers, (std::vector<std::string> { "skin", "fat", "muscle", "target", "steel" }));
        for (const Json& surface : view.at("surfaces"))
            EXPECT_NE(std::find(layers.begin(), layers.end(), surface.at("layer")), layers.end());
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(view.at("surgeon").at("eye").at(static_cast<std::size_t>(axis)), field->best_eye.eye[axis]);
        EXPECT_EQ(text.find('<'), std::string::npos); // it stands inside a script of the page
    }

    TEST_F(FieldView, ColoursTheTargetByTheEyesThatSeeIt)
    {
        const planner::Exposure& exposure = field->exposure;
        ASSERT_EQ(view.at("eyes").at("places").size(), exposure.eyes.size());
        double largest = 0.0;
        for (const planner::EyeView& eye : exposure.eyes)
            largest = std::max(largest, eye.visible_fraction);
        EXPECT_EQ(view.at("eyes").at("largest_share"), largest);
        const double most = *std::ranges::max_element(exposure.sample_seen);
        EXPECT_EQ(view.at("eyes").at("most_that_see"), std::lround(most * static_cast<double>(exposure.eyes.size())));
        for (const Json& surface : view.at("surfaces")) {
            EXPECT_EQ(surface.contains("seen"), surface.at("layer") == "target");
            if (!surface.contains("seen"))
                continue;
            const std::vector<std::uint8_t> seen = numbers<std::uint8_t>(surface.at("seen"));
            const std::vector<Vec3> at = positions(surface.at("opened"));
            ASSERT_EQ(seen.size(), at.size());
            for (std::size_t v = 0; v < at.size(); ++v) { // the nearest sample, found among all
                double nearest = 1e9, share = 0.0;
                for (std::size_t n = 0; n < exposure.sample_points.size(); ++n)
                    if (const double distance = (exposure.sample_points[n].position - at[v]).norm();
                        distance < nearest) {
                        nearest = distance;
                        share = static_cast<double>(exposure.sample_seen[n]);
                    }
                EXPECT_NEAR(seen[v], 255.0 * share / most, 1.0);
            }
        }
    }

    TEST_F(FieldView, StandsInTheReportWithItsViewer)
    {
        planner::Report report;
        report.title = "one field";
        report.fields = { field->metrics };
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "viewed.html";
        planner::write_report(path, report);
        EXPECT_EQ(content(path).find("<script"), std::string::npos); // no view, no script
        report.views = { { .approach = field->metrics.name, .scene = text } };
        report.viewer = field_viewer();
        planner::write_report(path, report);
        const std::string page = content(path);
        EXPECT_NE(page.find("<div class=\"field-view\" data-scene=\"scene-0\">"), std::string::npos);
        EXPECT_NE(page.find("id=\"scene-0\">" + text + "</script>"), std::string::npos);
        EXPECT_NE(page.find(std::string("<script>") + std::string(field_viewer()) + "</script>"), std::string::npos);
    }

    TEST(FieldViewer, IsTheBundleOfTheChecksum)
    {
        const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "viewer.js";
        std::ofstream(path, std::ios::binary) << field_viewer();
        std::ifstream in(RETRACTOR_VIEWER_CHECKSUM);
        std::string expected;
        in >> expected;
        EXPECT_EQ(planner::checksum(path), expected);
        EXPECT_EQ(field_viewer().find("</script"), std::string_view::npos);
        for (const char* elsewhere : { "src=\"http", "import(" })
            EXPECT_EQ(field_viewer().find(elsewhere), std::string_view::npos) << elsewhere;
    }

} // namespace field_view_test
} // namespace retractor::ui
