#include "haptics/hand/hand_file.h"

#include "haptics/spheres/surface_locator.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>
#include <utility>

namespace retractor::haptics {
namespace hand_file_test {

    /// The built-in hand as a file; faces near a fingertip in its group.
    void write_hand(const std::filesystem::path& path, const HandModel& hand, double scale, std::size_t fingers)
    {
        std::ofstream file(path);
        const Points& at = hand.surface.vertices;
        for (Eigen::Index v = 0; v < at.rows(); ++v)
            file << "v " << scale * at(v, 0) << ' ' << scale * at(v, 1) << ' ' << scale * at(v, 2) << '\n';
        std::string group;
        for (const auto& triangle : hand.surface.triangles) {
            std::string now = "rest";
            for (std::size_t f = 0; f < fingers; ++f)
                if ((at.row(triangle[0]).transpose() - hand.tips[f]).norm() < 1.3 * hand.tip_radius[f])
                    now = "fingertip-" + std::to_string(f + 1);
            if (now != group)
                file << "g " << now << '\n';
            group = now;
            file << "f " << triangle[0] + 1 << ' ' << triangle[1] + 1 << ' ' << triangle[2] + 1 << '\n';
        }
    }

    /// A fingertip's group far too small or large: a tetrahedron.
    void add_fifth_tip(const std::filesystem::path& path, const HandModel& hand, double edge)
    {
        std::ofstream file(path, std::ios::app);
        const auto first = hand.surface.vertices.rows() + 1;
        for (const Vec3& corner :
            { Vec3(0.0, 0.0, 0.0), Vec3(edge, 0.0, 0.0), Vec3(0.0, edge, 0.0), Vec3(0.0, 0.0, edge) })
            file << "v " << corner.x() << ' ' << corner.y() << ' ' << corner.z() << '\n';
        file << "g fingertip-5\n";
        for (const std::array<int, 3>& face :
            std::initializer_list<std::array<int, 3>> { { 0, 2, 1 }, { 0, 1, 3 }, { 1, 2, 3 }, { 2, 0, 3 } })
            file << "f " << first + face[0] << ' ' << first + face[1] << ' ' << first + face[2] << '\n';
    }

    TEST(HandFile, RefusesFingertipsOfNoHandsRadius)
    {
        const test_support::TemporaryFolder folder;
        const auto path = folder.path / "hand.obj";
        const HandModel hand = make_hand(false);
        // Corners of such a tetrahedron lie (3 sqrt(11) + sqrt(3)) / 16 of an edge from its middle, on average.
        for (const auto& [edge, radius] : { std::pair { 1.0, "0.73 mm" }, { 60.0, "43.80 mm" }, { 10.0, "" } }) {
            write_hand(path, hand, 1.0, 4);
            add_fifth_tip(path, hand, edge);
            const std::string expected = std::string(radius).empty()
                ? ""
                : path.string() + ": fingertip-5 has a radius of " + std::string(radius) + ", no fingertip's";
            const std::string message = test_support::message_of([&] { read_hand(path, false); });
            EXPECT_EQ(message.substr(0, expected.size()), expected);
            EXPECT_EQ(message.empty(), expected.empty()) << message;
        }
    }

    TEST(HandFile, ReadsAHandWithItsFingertips)
    {
        const test_support::TemporaryFolder folder;
        const HandModel right = make_hand(false);
        write_hand(folder.path / "hand.obj", right, 1.0, 5);
        const HandModel read = read_hand(folder.path / "hand.obj", false),
                        left = read_hand(folder.path / "hand.obj", true);
        EXPECT_EQ(read.surface.triangles.size(), right.surface.triangles.size());
        constexpr double kCap = 4.0; // mm: the middle of a cap's surface is not that of its ball
        for (std::size_t f = 0; f < 5; ++f) {
            EXPECT_LT((read.tips[f] - right.tips[f]).norm(), kCap) << f;
            EXPECT_NEAR(read.tip_radius[f], right.tip_radius[f], kCap) << f;
            EXPECT_EQ(left.tips[f].x(), -read.tips[f].x());
        }
        // Rounded to six digits in the file.
        const double volume = enclosed_volume(right.surface.vertices, right.surface.triangles);
        EXPECT_NEAR(enclosed_volume(read.surface.vertices, read.surface.triangles), volume, 1e-3 * volume);
        EXPECT_NEAR(enclosed_volume(left.surface.vertices, left.surface.triangles), volume, 1e-3 * volume);
    }

    TEST(HandFile, RefusesWhatIsNoHand)
    {
        const test_support::TemporaryFolder folder;
        const auto path = folder.path / "hand.obj";
        const auto message = [&] { return test_support::message_of([&] { read_hand(path, false); }); };
        EXPECT_NE(message().find("cannot be read"), std::string::npos);
        std::ofstream(path) << "v 0 0 0\n";
        EXPECT_NE(message().find("no faces"), std::string::npos);
        std::ofstream(path) << "v 0 0 nan\n";
        EXPECT_NE(message().find("three finite numbers"), std::string::npos);
        write_hand(path, make_hand(false), 1e-3, 5);
        EXPECT_NE(message().find("its unit must be the millimetre"), std::string::npos);
        write_hand(path, make_hand(false), 1.0, 4);
        EXPECT_NE(message().find("has no group fingertip-5"), std::string::npos);
    }

} // namespace hand_file_test
} // namespace retractor::haptics
