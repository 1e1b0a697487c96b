#include "ui/workstation/view/png_file.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <QBuffer>
#include <QImage>

namespace retractor::ui {

void write_png_file(const std::filesystem::path& path, const QImage& image)
{
    QByteArray bytes;
    QBuffer buffer(&bytes);
    buffer.open(QIODevice::WriteOnly);
    if (image.isNull() || !image.save(&buffer, "PNG"))
        throw IoError("the picture could not be made", path.string());
    write_file_atomically(path, std::string_view(bytes.constData(), static_cast<std::size_t>(bytes.size())));
}

} // namespace retractor::ui
