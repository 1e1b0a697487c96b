#include "planner/measures/volume_failures.h"

#include "planner/measures/metrics.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace retractor::planner {
namespace volume_failures_test {

    constexpr Label kMuscle = 1, kRib = 2;

    mesh::LabelTable table()
    {
        return { { kMuscle, "muscle", "muscle", mesh::Role::wall }, { kRib, "rib", "bone", mesh::Role::wall } };
    }

    /// Separate corners of cubes of 1 mm: tetrahedra of 1/6 mm^3, 10 mm apart along x.
    mesh::TetMesh corners(const std::vector<Label>& labels)
    {
        mesh::TetMesh wall;
        wall.labels = labels;
        wall.vertices.resize(static_cast<Eigen::Index>(4 * labels.size()), 3);
        for (std::size_t t = 0; t < labels.size(); ++t) {
            const Vec3 origin(10.0 * static_cast<double>(t), 0.0, 0.0);
            const Vec3 points[] = { origin, origin + Vec3::UnitX(), origin + Vec3::UnitY(), origin + Vec3::UnitZ() };
            for (std::size_t k = 0; k < 4; ++k) {
                wall.nodes.push_back(static_cast<VertexId>(4 * t + k));
                wall.vertices.row(static_cast<Eigen::Index>(4 * t + k)) = points[k].transpose();
            }
        }
        return wall;
    }

    TEST(VolumeFailures, TissueThatKeepsItsVolumeIsBelieved)
    {
        const VolumeFailures none
            = find_volume_failures(corners({ kMuscle, kMuscle, kMuscle }), std::vector { 0.9, 1.0, 1.1 }, table(), 0);
        EXPECT_EQ(none.elements, 0U);
        EXPECT_EQ(none.share, 0.0);
        EXPECT_EQ(none.smallest_ratio, 0.9);
        EXPECT_EQ(none.largest_ratio, 1.1);
        EXPECT_TRUE(none.believable) << "the ends belong to the range";
    }

    TEST(VolumeFailures, OnlySoftTissueCounts)
    {
        // One of three soft elements fails; the rib, which is squeezed more, does not count.
        const VolumeFailures failures = find_volume_failures(
            corners({ kMuscle, kRib, kMuscle, kMuscle }), std::vector { 1.0, 0.2, 1.5, 1.05 }, table(), 0);
        EXPECT_EQ(failures.elements, 1U);
        EXPECT_DOUBLE_EQ(failures.share, 1.0 / 3.0);
        EXPECT_EQ(failures.smallest_ratio, 1.0);
        EXPECT_EQ(failures.largest_ratio, 1.5);
        EXPECT_LT((failures.at - Vec3(20.25, 0.25, 0.25)).norm(), 1e-12);
        EXPECT_FALSE(failures.believable);
    }

    TEST(VolumeFailures, ThePlaceIsWhereTheVolumeChangesMost)
    {
        // A third of the volume is farther off than twice the volume; an element inside out is farthest off.
        const mesh::TetMesh wall = corners({ kMuscle, kMuscle, kMuscle });
        const auto x
            = [&](const std::vector<double>& ratios) { return find_volume_failures(wall, ratios, table(), 0).at.x(); };
        EXPECT_DOUBLE_EQ(x({ 2.0, 1.0 / 3.0, 1.0 }), 10.25);
        EXPECT_DOUBLE_EQ(x({ 2.0, 1.0 / 3.0, -0.1 }), 20.25);
    }

    TEST(VolumeFailures, AFewElementsAreAllowedAndAnInvertedOneIsNot)
    {
        constexpr std::size_t kElements = 2000;
        const mesh::TetMesh wall = corners(std::vector<Label>(kElements, kMuscle));
        std::vector<double> ratios(kElements, 1.0);
        std::fill_n(ratios.begin(), 80, 1.2); // 4 %
        EXPECT_TRUE(find_volume_failures(wall, ratios, table(), 0).believable);
        EXPECT_FALSE(find_volume_failures(wall, ratios, table(), 1).believable);
        std::fill_n(ratios.begin() + 80, 40, 0.8); // with them 6 %
        EXPECT_FALSE(find_volume_failures(wall, ratios, table(), 0).believable);
        EXPECT_TRUE(find_volume_failures(wall, std::vector<double>(kElements, 1.0), table(), 0).believable);
    }

    TEST(VolumeFailures, AWallWithoutSoftTissueHasNone)
    {
        const VolumeFailures none = find_volume_failures(corners({ kRib }), std::vector { 3.0 }, table(), 0);
        EXPECT_EQ(none.share, 0.0);
        EXPECT_TRUE(none.believable);
    }

    TEST(VolumeFailures, AveragesCancelWhatNeighboursExchange)
    {
        // Two elements of the same volume on both sides of a face: one gains what the other loses.
        mesh::TetMesh pair = corners({ kMuscle });
        pair.labels.push_back(kMuscle);
        pair.vertices.conservativeResize(5, 3);
        pair.vertices.row(4) = Vec3(-1.0, 0.0, 0.0).transpose();
        pair.nodes.insert(pair.nodes.end(), { 4, 0, 2, 3 });
        const std::vector<double> apart { 1.2, 0.8 };
        // Three of the four vertices belong to both.
        const std::vector<double> averaged = averaged_volume_ratios(pair, apart);
        EXPECT_DOUBLE_EQ(averaged[0], 0.25 * 1.2 + 0.75);
        EXPECT_DOUBLE_EQ(averaged[1], 0.25 * 0.8 + 0.75);
        pair.labels[1] = kRib; // another tissue is another patch
        for (const std::size_t t : { 0U, 1U })
            EXPECT_DOUBLE_EQ(averaged_volume_ratios(pair, apart)[t], apart[t]);
    }

    TEST(VolumeFailures, TheTextSaysThatTheNumbersAreNotToBeBelieved)
    {
        FieldMetrics field;
        EXPECT_TRUE(is_believable(field)) << "nothing was computed";
        EXPECT_EQ(volume_failure_text(field), "");
        field.volume_failures = VolumeFailures { .elements = 12,
            .share = 0.021,
            .smallest_ratio = 0.4,
            .largest_ratio = 1.83,
            .at = Vec3(1.0, 2.0, 3.0),
            .believable = false };
        field.inverted_elements = 2;
        field.volume_failures->believable = true;
        const std::string caution = volume_failure_text(field);
        EXPECT_EQ(caution.rfind("caution: 2.1 % of the soft tissue", 0), 0U) << caution;
        field.volume_failures->believable = false;
        const std::string text = volume_failure_text(field);
        for (const char* part : { "not usable: these numbers are not to be believed", "2.1 % of the soft tissue",
                 "0.40 and 1.83", "(1.0, 2.0, 3.0) mm", "2 element(s) are inside out" })
            EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
        field.volume_failures->place = "38 mm along the incision, 4 mm beside it and 12 mm deep";
        const std::string placed = volume_failure_text(field);
        EXPECT_NE(placed.find("most of all 38 mm along the incision"), std::string::npos) << placed;
        EXPECT_EQ(placed.find("(1.0"), std::string::npos) << placed;
        field.name = "straight";
        const nlohmann::ordered_json written = metrics_document({ field }).at("approaches").at(0).at("volume_failures");
        EXPECT_EQ(written.at("elements"), 12);
        EXPECT_EQ(written.at("share"), 0.021);
        EXPECT_EQ(written.at("smallest_ratio"), 0.4);
        EXPECT_EQ(written.at("largest_ratio"), 1.83);
        EXPECT_EQ(written.at("at_mm").at(2), 3.0);
        EXPECT_EQ(written.at("believable"), false);
    }

} // namespace volume_failures_test
} // namespace retractor::planner
