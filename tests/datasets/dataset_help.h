#pragma once
// What the tests of datasets share: data of others, volumes on oblique grids, calls that must be refused.

#include "mesh/base/error.h"
#include "mesh/image/volume.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

namespace retractor::test_support {

/// Third-party data for tests; the folder may be absent.
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

/// Anisotropic, odd sizes, all values different from their neighbours.
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

/// Every voxel of `a` is in `b` at the same place of the world, with the same value, whatever the order of axes.
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

/// Runs `call`, which must throw an Error whose text contains `part`.
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
