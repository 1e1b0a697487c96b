#include "planner/approach/incision_guide.h"

#include "mesh/tetrahedra/mesh_io.h"
#include "planner/approach/approach_templates.h"
#include "tests/support/block_case.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace retractor::planner {
namespace incision_guide_test {

    const test_support::ChestShape kShape {};

    Patient& chest()
    {
        static Patient made([] {
            datasets::Phantom phantom {};
            phantom.labels = test_support::synthetic_chest(kShape);
            return test_support::block_case("guide", phantom);
        }());
        return made;
    }

    Approach approach_of(const std::string& name)
    {
        ApproachRequest request;
        request.template_name = name;
        request.target.label = "aneurysm";
        return approach_from_template(*chest().labels(), *chest().anatomy(), request);
    }

    double volume_of(const TriMesh& mesh)
    {
        double volume = 0.0;
        for (const auto& t : mesh.triangles) {
            const Vec3 a = mesh.vertices.row(t[0]), b = mesh.vertices.row(t[1]), c = mesh.vertices.row(t[2]);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        return volume;
    }

    TEST(IncisionGuide, RibbonIsClosedAndHasItsVolume)
    {
        for (const char* name : { "median", "intercostal:4" }) {
            const Approach approach = approach_of(name);
            const TriMesh ribbon = guide_ribbon(approach, 6.0, 1.5, 2.0);
            std::map<std::pair<VertexId, VertexId>, int> edges;
            for (const auto& t : ribbon.triangles)
                for (int k = 0; k < 3; ++k) {
                    const VertexId a = t[static_cast<std::size_t>(k)], b = t[static_cast<std::size_t>((k + 1) % 3)];
                    ++edges[{ a, b }];
                }
            for (const auto& [edge, count] : edges) { // every edge once in each direction
                EXPECT_EQ(count, 1);
                EXPECT_EQ(edges.count({ edge.second, edge.first }), 1U);
            }
            // Two bars of 6 x 2 mm; on bent skin one is a little longer, and the far side of each as well.
            const double volume = 2.0 * 6.0 * 2.0 * incision_length(approach);
            EXPECT_NEAR(volume_of(ribbon), volume, 0.05 * volume);
            const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "ribbon.stl";
            mesh::write_stl(file, ribbon);
            EXPECT_EQ(std::filesystem::file_size(file), 84 + 50 * ribbon.triangles.size()); // binary STL
        }
    }

    TEST(IncisionGuide, MeasuresFromTheNotchAndTheXiphoid)
    {
        // The template begins 10 mm above the notch and ends 10 mm below the xiphoid, on a sternum along z.
        const Approach approach = approach_of("median");
        const std::vector<LandmarkDistance> landmarks = landmark_distances(chest(), approach);
        ASSERT_EQ(landmarks.size(), 2U);
        const double length = test_support::kSternumTop - test_support::kSternumBottom;
        constexpr double kVoxelMm = 3.0;
        EXPECT_EQ(landmarks[0].landmark, "jugular notch");
        EXPECT_NEAR(landmarks[0].to_start_mm, 10.0, kVoxelMm);
        EXPECT_NEAR(landmarks[0].to_end_mm, length + 10.0, 2.0 * kVoxelMm);
        EXPECT_NEAR(landmarks[1].to_start_mm, length + 10.0, 2.0 * kVoxelMm);
        EXPECT_NEAR(landmarks[1].to_end_mm, 10.0, kVoxelMm);
        const std::vector<std::string> sentences = theatre_sentences(chest(), approach);
        ASSERT_EQ(sentences.size(), 3U);
        EXPECT_EQ(sentences[0], "The incision starts on the midline and ends on the midline.");
        EXPECT_TRUE(sentences[1].starts_with("From the jugular notch ")) << sentences[1];
        for (const bool left : { true, false }) { // the sentence names the side
            const std::string side = theatre_sentences(chest(), approach_of(left ? "midcab" : "right-lateral")).front();
            EXPECT_NE(side.find(left ? "to the patient's left of" : "to the patient's right of"), std::string::npos);
            EXPECT_EQ(side.find(left ? "right" : "left"), std::string::npos) << side;
        }
    }

    TEST(IncisionGuide, MarkupIsACurveThroughTheIncision)
    {
        const Approach approach = approach_of("intercostal:4");
        const nlohmann::json document = nlohmann::json::parse(slicer_markup(approach));
        const nlohmann::json& markup = document.at("markups").at(0);
        EXPECT_EQ(markup.at("type"), "Curve");
        EXPECT_EQ(markup.at("coordinateSystem"), "LPS");
        ASSERT_EQ(markup.at("controlPoints").size(), approach.incision.size());
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            for (std::size_t axis = 0; axis < 3; ++axis)
                EXPECT_EQ(markup.at("controlPoints").at(n).at("position").at(axis),
                    approach.incision[n][static_cast<Eigen::Index>(axis)]);
    }

} // namespace incision_guide_test
} // namespace retractor::planner
