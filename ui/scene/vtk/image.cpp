#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "ui/scene/vtk/render.h"
#include "mesh/base/vtk_errors.h"

#include <vtkImageData.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <string_view>

namespace retractor::ui {

void write_png(const std::filesystem::path& path, const Image& image)
{
    const std::size_t row = 3UL * static_cast<std::size_t>(std::max(image.width, 0));
    if (image.width <= 0 || image.height <= 0 || image.rgb.size() != row * static_cast<std::size_t>(image.height))
        throw InputError("an empty or incomplete image cannot be written", path.string());
    const VtkErrorTrap trap;
    auto data = vtkSmartPointer<vtkImageData>::New();
    data->SetDimensions(image.width, image.height, 1);
    data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    for (int y = 0; y < image.height; ++y)
        std::copy_n(image.rgb.data() + row * static_cast<std::size_t>(y), row,
            static_cast<unsigned char*>(data->GetScalarPointer(0, image.height - 1 - y, 0)));
    auto writer = vtkSmartPointer<vtkPNGWriter>::New();
    writer->WriteToMemoryOn();
    writer->SetInputData(data);
    writer->Write();
    trap.throw_if_error("writing " + path.string());
    vtkUnsignedCharArray* bytes = writer->GetResult();
    write_file_atomically(path,
        std::string_view(
            reinterpret_cast<const char*>(bytes->GetPointer(0)), static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

} // namespace retractor::ui
