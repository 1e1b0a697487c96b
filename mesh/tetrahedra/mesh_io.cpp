#include "mesh/tetrahedra/mesh_io.h"

#include "mesh/base/assert.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/vtk_errors.h"

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <vtkStringArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace retractor::mesh {

namespace {

    constexpr const char* kFrame = "LPS";

    vtkNew<vtkPoints> vtk_points(const Points& points)
    {
        vtkNew<vtkPoints> result;
        result->SetDataTypeToDouble();
        result->SetNumberOfPoints(points.rows());
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            result->SetPoint(v, points(v, 0), points(v, 1), points(v, 2));
        return result;
    }

    /// Adds the rows of `values`, a table with `columns` columns.
    void add_array(vtkFieldData* to, const std::string& name, std::span<const double> values, int columns,
        vtkIdType expected, const char* what)
    {
        RETRACTOR_ASSERT(values.size() % static_cast<std::size_t>(columns) == 0);
        const auto rows = static_cast<vtkIdType>(values.size()) / columns;
        if (rows != expected)
            throw InputError(
                "field has " + std::to_string(rows) + what + ", the mesh needs " + std::to_string(expected), name);
        vtkNew<vtkDoubleArray> array;
        array->SetName(name.c_str());
        array->SetNumberOfComponents(columns);
        array->SetNumberOfTuples(rows);
        std::copy(values.begin(), values.end(), array->GetPointer(0));
        to->AddArray(array);
    }

    void add_text(vtkDataSet* to, const std::string& name, const std::string& text)
    {
        vtkNew<vtkStringArray> array;
        array->SetName(name.c_str());
        array->InsertNextValue(text);
        to->GetFieldData()->AddArray(array);
    }

    void add_fields(vtkDataSet* to, const MeshFields& fields, const std::vector<Label>& labels)
    {
        for (const auto& [name, values] : fields.point_vectors)
            add_array(to->GetPointData(), name, std::span(values.data(), static_cast<std::size_t>(values.size())), 3,
                to->GetNumberOfPoints(), " rows");
        for (const auto& [name, values] : fields.point_scalars)
            add_array(to->GetPointData(), name, values, 1, to->GetNumberOfPoints(), " values");
        for (const auto& [name, values] : fields.cell_scalars)
            add_array(to->GetCellData(), name, values, 1, to->GetNumberOfCells(), " values");
        if (!labels.empty()) {
            vtkNew<vtkUnsignedShortArray> array;
            array->SetName("label");
            array->SetNumberOfTuples(static_cast<vtkIdType>(labels.size()));
            std::copy(labels.begin(), labels.end(), array->GetPointer(0));
            to->GetCellData()->AddArray(array);
        }
        add_text(to, "frame", kFrame);
        for (const auto& [name, text] : fields.texts)
            add_text(to, name, text);
    }

    template <class Writer> void write_xml(const std::filesystem::path& path, vtkDataObject* data)
    {
        write_file_atomically(path, [&](const std::filesystem::path& temporary) {
            const VtkErrorTrap silent; // the writer's code tells as much
            vtkNew<Writer> writer;
            writer->SetInputDataObject(data);
            writer->SetFileName(temporary.c_str());
            writer->SetDataModeToAppended();
            writer->EncodeAppendedDataOff();
            if (writer->Write() == 0 || writer->GetErrorCode() != 0)
                throw IoError("cannot write the mesh", path.string());
        });
    }

    int cell_type(const TetMesh& mesh) { return mesh.nodes_per_tet == 4 ? VTK_TETRA : VTK_QUADRATIC_TETRA; }

    void check_triangles(const TriMesh& mesh)
    {
        if (!mesh.vertices.allFinite())
            throw InputError("a vertex of the surface is not finite");
        if (!mesh.labels.empty() && mesh.labels.size() != mesh.triangles.size())
            throw InputError("the surface has " + std::to_string(mesh.triangles.size()) + " triangles and "
                + std::to_string(mesh.labels.size()) + " labels");
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const VertexId v : mesh.triangles[t])
                if (v < 0 || v >= mesh.vertices.rows())
                    throw InputError("a triangle names a vertex that does not exist", "triangle " + std::to_string(t));
    }

    std::vector<double> values_of(vtkDataArray* array)
    {
        std::vector<double> values(static_cast<std::size_t>(array->GetNumberOfTuples()));
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = array->GetComponent(static_cast<vtkIdType>(i), 0);
        return values;
    }

    void read_fields(vtkUnstructuredGrid* grid, MeshFields& fields)
    {
        vtkPointData* points = grid->GetPointData();
        for (int a = 0; a < points->GetNumberOfArrays(); ++a) {
            vtkDataArray* array = points->GetArray(a);
            if (array == nullptr || array->GetName() == nullptr)
                continue;
            if (array->GetNumberOfComponents() == 1)
                fields.point_scalars[array->GetName()] = values_of(array);
            if (array->GetNumberOfComponents() == 3) {
                Points& values = fields.point_vectors[array->GetName()];
                values.resize(array->GetNumberOfTuples(), 3);
                for (Eigen::Index v = 0; v < values.rows(); ++v)
                    for (int c = 0; c < 3; ++c)
                        values(v, c) = array->GetComponent(v, c);
            }
        }
        vtkCellData* cells = grid->GetCellData();
        for (int a = 0; a < cells->GetNumberOfArrays(); ++a)
            if (vtkDataArray* array = cells->GetArray(a); array != nullptr && array->GetName() != nullptr
                && array->GetNumberOfComponents() == 1 && std::string(array->GetName()) != "label")
                fields.cell_scalars[array->GetName()] = values_of(array);
    }

    /// Keeps the text of the first error that VTK reports as an event, and keeps VTK from writing to standard error.
    class ErrorNote {
    public:
        explicit ErrorNote(vtkObject* source)
        {
            command_->SetClientData(this);
            command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
                auto& message = static_cast<ErrorNote*>(self)->message_;
                if (message.empty() && text != nullptr)
                    message = static_cast<const char*>(text);
            });
            source->AddObserver(vtkCommand::ErrorEvent, command_);
        }
        bool failed() const { return !message_.empty(); }

    private:
        vtkNew<vtkCallbackCommand> command_;
        std::string message_;
    };

} // namespace

void write_vtu(const std::filesystem::path& path, const TetMesh& mesh, const MeshFields& fields)
{
    check_mesh(mesh);
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(vtk_points(mesh.vertices));
    vtkNew<vtkCellArray> cells;
    std::array<vtkIdType, 10> nodes {};
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto tet = mesh.tet(t);
        std::copy(tet.begin(), tet.end(), nodes.begin());
        cells->InsertNextCell(mesh.nodes_per_tet, nodes.data());
    }
    grid->SetCells(cell_type(mesh), cells);
    add_fields(grid, fields, mesh.labels);
    write_xml<vtkXMLUnstructuredGridWriter>(path, grid);
}

TetMesh read_vtu(const std::filesystem::path& path, MeshFields* fields)
{
    const auto refuse = [&](const std::string& what) -> void { throw IoError(what, path.string()); };
    if (!std::filesystem::is_regular_file(path))
        refuse("no such mesh file");
    vtkNew<vtkXMLUnstructuredGridReader> reader;
    const ErrorNote errors(reader);
    reader->SetFileName(path.c_str());
    if (reader->CanReadFile(path.c_str()) == 0)
        refuse("not a VTU file");
    reader->Update();
    vtkUnstructuredGrid* grid = reader->GetOutput();
    if (errors.failed() || reader->GetErrorCode() != 0 || grid == nullptr)
        refuse("the VTU file is damaged");
    if (grid->GetNumberOfCells() == 0)
        refuse("the VTU file has no elements");

    auto* frame = vtkStringArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("frame"));
    if (frame == nullptr || frame->GetNumberOfValues() == 0)
        refuse("the VTU file does not state its frame: no field data string \"frame\"");
    if (frame->GetValue(0) != kFrame)
        refuse("the VTU file's frame is \"" + std::string(frame->GetValue(0)) + "\", not LPS");
    vtkDataArray* labels = grid->GetCellData()->GetArray("label");
    if (labels == nullptr || labels->GetNumberOfComponents() != 1)
        refuse("the VTU file has no cell array \"label\"");

    TetMesh mesh;
    const int type = grid->GetCellType(0);
    if (type != VTK_TETRA && type != VTK_QUADRATIC_TETRA)
        refuse("the VTU file has elements that are no tetrahedra: cell 0");
    mesh.nodes_per_tet = type == VTK_TETRA ? 4 : 10;
    mesh.vertices.resize(grid->GetNumberOfPoints(), 3);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        grid->GetPoint(v, mesh.vertices.row(v).data());
    for (vtkIdType t = 0; t < grid->GetNumberOfCells(); ++t) {
        vtkIdType count = 0;
        const vtkIdType* nodes = nullptr;
        grid->GetCellPoints(t, count, nodes);
        if (grid->GetCellType(t) != type || count != mesh.nodes_per_tet)
            refuse("the VTU file has elements of another type: cell " + std::to_string(t));
        for (vtkIdType i = 0; i < count; ++i) {
            if (nodes[i] < 0 || nodes[i] >= grid->GetNumberOfPoints())
                refuse("the VTU file names a point that does not exist: cell " + std::to_string(t));
            mesh.nodes.push_back(static_cast<VertexId>(nodes[i]));
        }
        const double label = labels->GetComponent(t, 0);
        if (!(label >= 0.0 && label <= std::numeric_limits<Label>::max()) || label != std::floor(label))
            refuse("the VTU file has a label out of range: cell " + std::to_string(t));
        mesh.labels.push_back(static_cast<Label>(label));
    }
    check_mesh(mesh);
    if (fields != nullptr)
        read_fields(grid, *fields);
    return mesh;
}

namespace {

    vtkNew<vtkPolyData> vtk_surface(const TriMesh& mesh)
    {
        check_triangles(mesh);
        vtkNew<vtkPolyData> surface;
        surface->SetPoints(vtk_points(mesh.vertices));
        vtkNew<vtkCellArray> cells;
        for (const auto& triangle : mesh.triangles) {
            const std::array<vtkIdType, 3> nodes { triangle[0], triangle[1], triangle[2] };
            cells->InsertNextCell(3, nodes.data());
        }
        surface->SetPolys(cells);
        return surface;
    }

} // namespace

void write_vtp(const std::filesystem::path& path, const TriMesh& mesh, const MeshFields& fields)
{
    const vtkNew<vtkPolyData> surface = vtk_surface(mesh);
    add_fields(surface, fields, mesh.labels);
    write_xml<vtkXMLPolyDataWriter>(path, surface);
}

void write_stl(const std::filesystem::path& path, const TriMesh& mesh)
{
    const vtkNew<vtkPolyData> surface = vtk_surface(mesh);
    write_file_atomically(path, [&](const std::filesystem::path& temporary) {
        const VtkErrorTrap silent;
        vtkNew<vtkSTLWriter> writer;
        writer->SetInputData(surface);
        writer->SetFileTypeToBinary();
        writer->SetFileName(temporary.c_str());
        if (writer->Write() == 0 || writer->GetErrorCode() != 0)
            throw IoError("cannot write the surface", path.string());
    });
}

} // namespace retractor::mesh
