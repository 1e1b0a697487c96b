#include "tests/ui/scene/png_files.h"

#include "mesh/base/error.h"
#include "mesh/base/vtk_errors.h"

#include <vtkImageData.h>
#include <vtkPNGReader.h>
#include <vtkSmartPointer.h>

#include <cmath>
#include <limits>

namespace retractor::ui::samples {

Image read_png(const std::filesystem::path& path)
{
    const VtkErrorTrap trap;
    auto reader = vtkSmartPointer<vtkPNGReader>::New();
    if (!std::filesystem::exists(path))
        throw IoError("there is no such file", path.string());
    if (reader->CanReadFile(path.c_str()) == 0)
        throw IoError("this is no PNG file", path.string());
    reader->SetFileName(path.c_str());
    reader->Update();
    trap.throw_if_error("reading " + path.string());
    vtkImageData& data = *reader->GetOutput();
    const int components = data.GetNumberOfScalarComponents();
    if (data.GetScalarType() != VTK_UNSIGNED_CHAR || components < 3)
        throw IoError("only 8-bit colour PNG files are read", path.string());
    Image image { .width = data.GetDimensions()[0], .height = data.GetDimensions()[1], .rgb = {} };
    for (int y = image.height - 1; y >= 0; --y)
        for (int x = 0; x < image.width; ++x) {
            const auto* pixel = static_cast<const unsigned char*>(data.GetScalarPointer(x, y, 0));
            image.rgb.insert(image.rgb.end(), pixel, pixel + 3);
        }
    return image;
}

double psnr_db(const Image& a, const Image& b)
{
    if (a.width != b.width || a.height != b.height || a.rgb.size() != b.rgb.size() || a.rgb.empty())
        throw InputError("images of different sizes cannot be compared");
    double sum = 0.0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        const double d = static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]);
        sum += d * d;
    }
    if (sum == 0.0)
        return std::numeric_limits<double>::infinity();
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.rgb.size()) / sum);
}

} // namespace retractor::ui::samples
