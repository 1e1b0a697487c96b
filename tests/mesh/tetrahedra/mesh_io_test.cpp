#include "mesh/tetrahedra/mesh_io.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <unistd.h>

namespace retractor::mesh {
namespace mesh_io_test {

    namespace fs = std::filesystem;

    class MeshIo : public ::testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::temp_directory_path() / ("retractor_mesh_io_" + std::to_string(::getpid()));
            fs::create_directories(folder_);
        }
        void TearDown() override { fs::remove_all(folder_); }

        std::string content(const fs::path& path) const
        {
            std::ifstream in(path, std::ios::binary);
            return { std::istreambuf_iterator<char>(in), {} };
        }
        void rewrite(const fs::path& path, const std::string& from, const std::string& to) const
        {
            std::string text = content(path);
            const std::size_t at = text.find(from);
            ASSERT_NE(at, std::string::npos);
            text.replace(at, from.size(), to);
            std::ofstream(path, std::ios::binary) << text;
        }
        void expect_refused(const fs::path& path, const std::string& text) const
        {
            try {
                static_cast<void>(read_vtu(path));
                ADD_FAILURE() << "not refused: " << text;
            } catch (const IoError& error) {
                EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
                EXPECT_EQ(error.where(), path.string());
            }
        }

        fs::path folder_;
    };

    TetMesh box()
    {
        TetMesh mesh = kuhn_box(2, 3, 1, 0.1); // coordinates with no short binary form
        for (std::size_t t = 0; t < mesh.tet_count(); ++t)
            mesh.labels[t] = static_cast<Label>(t % 3 + 300);
        return mesh;
    }

    TEST_F(MeshIo, LinearMeshAndFieldsComeBackBitForBit)
    {
        const TetMesh mesh = box();
        MeshFields fields;
        fields.point_vectors["displacement"] = mesh.vertices * 0.3;
        fields.point_scalars["depth"] = std::vector<double>(mesh.vertex_count(), 1.0 / 3.0);
        fields.cell_scalars["strain"] = std::vector<double>(mesh.tet_count(), 0.07);
        write_vtu(folder_ / "a.vtu", mesh, fields);
        MeshFields read;
        const TetMesh copy = read_vtu(folder_ / "a.vtu", &read);
        EXPECT_EQ(copy.vertices, mesh.vertices);
        EXPECT_EQ(copy.nodes, mesh.nodes);
        EXPECT_EQ(copy.labels, mesh.labels);
        EXPECT_EQ(copy.nodes_per_tet, 4);
        EXPECT_EQ(read.point_vectors, fields.point_vectors);
        EXPECT_EQ(read.point_scalars, fields.point_scalars);
        EXPECT_EQ(read.cell_scalars, fields.cell_scalars);
    }

    TEST_F(MeshIo, QuadraticMeshComesBack)
    {
        const TetMesh mesh = with_midpoints(box());
        write_vtu(folder_ / "a.vtu", mesh);
        const TetMesh copy = read_vtu(folder_ / "a.vtu");
        EXPECT_EQ(copy.nodes_per_tet, 10);
        EXPECT_EQ(copy.nodes, mesh.nodes);
        EXPECT_EQ(copy.vertices, mesh.vertices);
    }

    TEST_F(MeshIo, FilesStateTheirFrame)
    {
        write_vtu(folder_ / "a.vtu", box());
        EXPECT_NE(content(folder_ / "a.vtu").find("Name=\"frame\""), std::string::npos);
        TriMesh triangle;
        triangle.vertices = Points::Identity(3, 3);
        triangle.triangles = { { 0, 1, 2 } };
        triangle.labels = { 5 };
        write_vtp(folder_ / "a.vtp", triangle);
        const std::string text = content(folder_ / "a.vtp");
        EXPECT_NE(text.find("Name=\"frame\""), std::string::npos);
        EXPECT_NE(text.find("Name=\"label\""), std::string::npos);
        EXPECT_NE(text.find("NumberOfPolys=\"1\""), std::string::npos);
    }

    TEST_F(MeshIo, MissingArraysAndDamageAreNamed)
    {
        expect_refused(folder_ / "none.vtu", "no such mesh file");
        std::ofstream(folder_ / "text.vtu") << "not xml";
        expect_refused(folder_ / "text.vtu", "not a VTU file");
        const fs::path file = folder_ / "a.vtu";
        write_vtu(file, box());
        rewrite(file, "Name=\"label\"", "Name=\"lapel\"");
        expect_refused(file, "no cell array \"label\"");
        write_vtu(file, box());
        rewrite(file, "Name=\"frame\"", "Name=\"flame\"");
        expect_refused(file, "does not state its frame");
        write_vtu(file, box());
        fs::resize_file(file, fs::file_size(file) / 2);
        expect_refused(file, "damaged");
    }

    TEST_F(MeshIo, BadMeshesAndFieldsAreRefused)
    {
        TetMesh inverted = box();
        std::swap(inverted.nodes[0], inverted.nodes[1]);
        EXPECT_THROW(write_vtu(folder_ / "a.vtu", inverted), InputError);
        MeshFields fields;
        fields.cell_scalars["strain"] = { 1.0 };
        try {
            write_vtu(folder_ / "a.vtu", box(), fields);
            ADD_FAILURE();
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "strain");
        }
        TriMesh triangle;
        triangle.vertices = Points::Identity(3, 3);
        triangle.triangles = { { 0, 1, 3 } };
        EXPECT_THROW(write_vtp(folder_ / "a.vtp", triangle), InputError);
        EXPECT_TRUE(fs::is_empty(folder_));
        EXPECT_THROW(write_vtu(folder_ / "missing" / "a.vtu", box()), IoError);
    }

} // namespace mesh_io_test
} // namespace retractor::mesh
