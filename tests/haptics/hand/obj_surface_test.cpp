#include "haptics/hand/obj_surface.h"

#include "haptics/spheres/surface_locator.h"
#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

using namespace retractor;
using namespace retractor::haptics;

namespace obj_surface_test {

struct ObjFile {
    std::filesystem::path path;
    explicit ObjFile(const std::string& text)
        : path(std::filesystem::temp_directory_path() / ("retractor-obj-" + std::to_string(::getpid()) + ".obj"))
    {
        std::ofstream(path) << text;
    }
    ~ObjFile() { std::filesystem::remove(path); }
};

std::string message_of(const std::string& text)
{
    const ObjFile file(text);
    try {
        (void)read_obj_surface(file.path);
    } catch (const Error& error) {
        return std::string(error.what()) + " [" + error.where().substr(error.where().rfind(".obj")) + "]";
    }
    return {};
}

constexpr const char* kTetrahedron = "# centimetres\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 1\n"
                                     "f 1 3 2\nf 1/1 2/2 4/3\nf 1//1 -1//1 3//1\nf 2 3 4\n";

TEST(ObjSurface, joinsSeamsAndScales)
{
    const ObjFile file(kTetrahedron);
    const TriMesh mesh = read_obj_surface(file.path, 10.0);
    EXPECT_EQ(mesh.vertices.rows(), 4); // the fifth repeats the fourth
    EXPECT_EQ(mesh.triangles.size(), 4U);
    EXPECT_NEAR(enclosed_volume(mesh.vertices, mesh.triangles), 1000.0 / 6.0, 1e-9);
    EXPECT_NO_THROW(SurfaceLocator { mesh });
}

TEST(ObjSurface, fansPolygons)
{
    const ObjFile file("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    EXPECT_EQ(read_obj_surface(file.path).triangles.size(), 2U);
}

TEST(ObjSurface, namesTheLineThatIsWrong)
{
    EXPECT_EQ(message_of("v 0 0\n"), "a vertex needs three finite numbers [.obj:1]");
    EXPECT_EQ(message_of("v 0 0 0\nf 1 2 3\n"), "a face has a corner that does not exist: 2 [.obj:2]");
    EXPECT_EQ(message_of("v 0 0 0\nv 1 0 0\nf 1 2\n"), "a face needs three corners [.obj:3]");
    EXPECT_EQ(message_of("v 0 0 0\nf 1 x 1\n"), "a face has a corner that is no number: x [.obj:2]");
    EXPECT_EQ(message_of("v 0 0 0\n"), "the file has no faces [.obj]");
    EXPECT_THROW((void)read_obj_surface("/no/such/file.obj"), IoError);
}

} // namespace obj_surface_test
