#pragma once
// A temporary folder for one test, oblique grids for tests of geometry, and a check for refused input.

#include "mesh/base/error.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace retractor::test_support {

/// A new empty folder, which the destructor removes with its contents.
class TemporaryFolder {
public:
    TemporaryFolder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "retractor-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr)
            throw IoError("no temporary folder could be made", name);
        path = name;
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored; // it lies in the folder for temporary files
        std::filesystem::remove_all(path, ignored);
    }
    std::filesystem::path operator/(const std::string& name) const { return path / name; }

    std::filesystem::path path;
};

/// Path of third-party data for tests; the folder may be absent.
inline std::filesystem::path shared_data(const std::string& name)
{
    const char* folder = std::getenv("RETRACTOR_SHARED_DATA");
    return std::filesystem::path(folder != nullptr ? folder : RETRACTOR_SHARED_DATA_DEFAULT) / name;
}

inline Mat3 oblique_rotation()
{
    return (Eigen::AngleAxisd(0.41, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.73, Vec3::UnitX())
        * Eigen::AngleAxisd(1.17, Vec3::UnitY()))
        .toRotationMatrix();
}

inline Mat3 mirrored(int axis)
{
    Mat3 direction = oblique_rotation();
    direction.col(axis) *= -1.0;
    return direction;
}

/// A volume of 9 x 7 x 5 voxels with anisotropic spacing and random values (HU).
inline mesh::Volume random_volume(const Mat3& direction)
{
    mesh::Volume volume;
    volume.grid.size = { 9, 7, 5 };
    volume.grid.spacing = { 0.7, 1.3, 2.5 };
    volume.grid.origin = { -101.25, 37.5, 812.125 };
    volume.grid.direction = direction;
    std::mt19937 random(7);
    std::uniform_int_distribution<int> hu(-1024, 3071);
    volume.voxels.resize(volume.grid.voxel_count());
    for (auto& v : volume.voxels)
        v = static_cast<std::int16_t>(hu(random));
    return volume;
}

/// Expects every voxel of `a` at the same world position in `b`, within `tolerance_mm` and with the same value; the
/// order of axes may differ.
inline void expect_same_in_world(const mesh::Volume& a, const mesh::Volume& b, double tolerance_mm)
{
    ASSERT_EQ(a.voxels.size(), b.voxels.size());
    for (int k = 0; k < a.grid.size[2]; ++k)
        for (int j = 0; j < a.grid.size[1]; ++j)
            for (int i = 0; i < a.grid.size[0]; ++i) {
                const Vec3 world = a.grid.world(Vec3(i, j, k));
                const Eigen::Vector3i n = b.grid.index(world).array().round().cast<int>();
                ASSERT_TRUE(b.grid.contains(n.x(), n.y(), n.z())) << world.transpose();
                ASSERT_LT((b.grid.world(n.cast<double>()) - world).norm(), tolerance_mm);
                ASSERT_EQ(b.voxels[b.grid.offset(n.x(), n.y(), n.z())], a.voxels[a.grid.offset(i, j, k)]);
            }
}

/// Expects that `call` throws an `Exception` whose text "what @ where" contains `part`.
template <typename Exception, typename Call> void expect_refused(const Call& call, const std::string& part)
{
    try {
        call();
        FAIL() << "nothing was thrown, expected: " << part;
    } catch (const Exception& error) {
        EXPECT_NE((std::string(error.what()) + " @ " + error.where()).find(part), std::string::npos)
            << error.what() << " @ " << error.where();
    }
}

} // namespace retractor::test_support
