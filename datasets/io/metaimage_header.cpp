#include "datasets/io/metaimage_header.h"

#include "datasets/io/header_text.h"
#include "mesh/base/error.h"

#include <cmath>
#include <fstream>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    struct HeaderText {
        std::map<std::string, std::string> fields;
        std::vector<fs::path> data_files; ///< empty when the data follow the header
        std::uint64_t end = 0;
    };

    HeaderText read_text(const fs::path& path)
    {
        const std::string where = path.string();
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw IoError("cannot open the file", where);
        HeaderText header;
        std::string line;
        while (!header.fields.contains("ElementDataFile")) {
            if (!next_header_line(file, line, where))
                throw InputError("the MetaImage header is cut short (no ElementDataFile)", where);
            const std::size_t equals = line.find('=');
            if (equals == std::string::npos && trimmed(line).empty())
                continue;
            if (equals == std::string::npos)
                throw InputError("not a MetaImage header: it has a line that is no field", where);
            const std::string name = trimmed(line.substr(0, equals));
            if (!header.fields.emplace(name, trimmed(line.substr(equals + 1))).second)
                throw InputError("the field \"" + name + "\" is given twice", where);
        }
        const std::string& data = header.fields["ElementDataFile"];
        if (lower_case(data) == "local")
            header.end = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file.tellg()));
        else
            header.data_files = data_files(path, data, file);
        return header;
    }

    /// The fields of one header. A field may have several names.
    class Fields {
    public:
        Fields(const std::map<std::string, std::string>& fields, const std::string& where)
            : fields_(fields)
            , where_(where)
        {
        }
        const std::string* find(std::initializer_list<const char*> names) const
        {
            const std::string* value = nullptr;
            for (const char* name : names) {
                const auto found = fields_.find(name);
                if (found == fields_.end())
                    continue;
                if (value != nullptr && *value != found->second)
                    throw InputError(
                        std::string("two fields disagree: \"") + *names.begin() + "\" and \"" + name + "\"", where_);
                value = &found->second;
            }
            return value;
        }
        const std::string& required(const char* name) const
        {
            const std::string* value = find({ name });
            if (value == nullptr)
                throw InputError(std::string("the header has no field \"") + name + "\"", where_);
            return *value;
        }
        bool flag(std::initializer_list<const char*> names, bool otherwise) const
        {
            const std::string* value = find(names);
            if (value == nullptr)
                return otherwise;
            const std::string text = lower_case(*value);
            if (text == "true" || text == "1")
                return true;
            if (text == "false" || text == "0")
                return false;
            throw InputError(std::string("\"") + *names.begin() + "\" must be True or False", where_);
        }
        std::vector<double> numbers(std::initializer_list<const char*> names, std::size_t count) const
        {
            const std::string* value = find(names);
            if (value == nullptr)
                return {};
            std::vector<double> numbers = numbers_in(*value, *names.begin(), where_);
            if (numbers.size() != count)
                throw InputError(std::string("\"") + *names.begin() + "\" must have " + std::to_string(count)
                        + " numbers, it has " + std::to_string(numbers.size()),
                    where_);
            return numbers;
        }

    private:
        const std::map<std::string, std::string>& fields_;
        const std::string& where_;
    };

    VoxelType type_of(const std::string& text, const std::string& where)
    {
        static const std::map<std::string, VoxelType> kTypes { { "MET_CHAR", VoxelType::int8 },
            { "MET_UCHAR", VoxelType::uint8 }, { "MET_SHORT", VoxelType::int16 }, { "MET_USHORT", VoxelType::uint16 },
            { "MET_INT", VoxelType::int32 }, { "MET_UINT", VoxelType::uint32 }, { "MET_LONG", VoxelType::int32 },
            { "MET_ULONG", VoxelType::uint32 }, { "MET_LONG_LONG", VoxelType::int64 },
            { "MET_ULONG_LONG", VoxelType::uint64 }, { "MET_FLOAT", VoxelType::float32 },
            { "MET_DOUBLE", VoxelType::float64 } };
        const auto found = kTypes.find(text);
        if (found == kTypes.end())
            throw InputError("the ElementType \"" + text + "\" is not one number per voxel", where);
        return found->second;
    }

    /// Checks the letters of "AnatomicalOrientation". By ITK's custom a letter names the side where the axis begins
    /// (RAI is LPS). By the text of the format a letter names the side where the axis ends. Letters are accepted when
    /// one of the two readings fits the matrix, or the identity in a header without matrix. Other letters give a note,
    /// or without a matrix an error.
    void check_letters(const Fields& fields, bool has_matrix, ImageHeader& header)
    {
        const std::string* text = fields.find({ "AnatomicalOrientation" });
        if (text == nullptr || text->find('?') != std::string::npos || text->empty())
            return;
        std::string from_letters;
        std::string to_letters;
        for (int a = 0; a < 3; ++a) {
            Eigen::Index axis = 0;
            header.grid.direction.col(a).cwiseAbs().maxCoeff(&axis);
            const bool positive = header.grid.direction(axis, a) > 0.0;
            from_letters += positive ? "RAI"[axis] : "LPS"[axis];
            to_letters += positive ? "LPS"[axis] : "RAI"[axis];
        }
        if (*text == from_letters || *text == to_letters)
            return;
        if (!has_matrix)
            throw InputError("AnatomicalOrientation \"" + *text
                    + "\" without a TransformMatrix: two customs exist for these letters; write the matrix",
                header.where);
        header.notes.push_back("AnatomicalOrientation \"" + *text + "\" contradicts the TransformMatrix ("
            + from_letters + "): the matrix is taken");
    }

    void set_geometry(const Fields& fields, ImageHeader& header)
    {
        const std::string& where = header.where;
        std::vector<double> spacing = fields.numbers({ "ElementSpacing" }, 3);
        if (spacing.empty()) {
            spacing = fields.numbers({ "ElementSize" }, 3);
            if (spacing.empty())
                throw InputError("the header has no field \"ElementSpacing\"", where);
            header.notes.emplace_back("the header has no ElementSpacing: ElementSize is taken");
        }
        Mat3 steps = Mat3::Identity();
        const std::vector<double> matrix = fields.numbers({ "TransformMatrix", "Rotation", "Orientation" }, 9);
        for (std::size_t m = 0; m < matrix.size(); ++m) // the matrix lists one axis after the other
            steps(static_cast<Eigen::Index>(m % 3), static_cast<Eigen::Index>(m / 3)) = matrix[m];
        for (int a = 0; a < 3; ++a) {
            const double length = spacing[static_cast<std::size_t>(a)];
            if (!(std::isfinite(length) && length > 0.0))
                throw InputError("\"ElementSpacing\" must be positive and finite", where);
            constexpr double kUnit = 1e-4; // as in check_grid()
            if (!(std::abs(steps.col(a).norm() - 1.0) <= kUnit))
                throw InputError("the axes of \"TransformMatrix\" must be unit vectors", where);
            steps.col(a) *= length;
        }
        set_steps(header.grid, steps, where);
        const std::vector<double> origin = fields.numbers({ "Offset", "Position", "Origin" }, 3);
        if (origin.empty())
            header.notes.emplace_back("the header names no Offset: taken as (0, 0, 0)");
        else
            header.grid.origin = Vec3(origin[0], origin[1], origin[2]);
        if (!header.grid.origin.allFinite())
            throw InputError("\"Offset\" must be finite", where);
        check_letters(fields, !matrix.empty(), header);
        if (const std::string* unit = fields.find({ "DistanceUnits" }))
            if (lower_case(*unit) != "mm" && *unit != "?" && !unit->empty())
                throw InputError("DistanceUnits \"" + *unit + "\" is not read: use mm", where);
    }

    VoxelStore store_of(const Fields& fields, const HeaderText& text, const fs::path& path)
    {
        const std::string where = path.string();
        VoxelStore store;
        store.type = type_of(fields.required("ElementType"), where);
        store.big_endian = fields.flag({ "BinaryDataByteOrderMSB", "ElementByteOrderMSB" }, false);
        store.encoding = Encoding::raw;
        if (!fields.flag({ "BinaryData" }, true)) {
            store.encoding = Encoding::text;
            store.big_endian = std::endian::native == std::endian::big;
        }
        if (fields.flag({ "CompressedData" }, false)) {
            if (store.encoding == Encoding::text)
                throw InputError("\"CompressedData\" needs \"BinaryData\"", where);
            store.encoding = Encoding::deflate;
        }
        store.files = text.data_files;
        if (store.files.empty()) {
            store.files = { path };
            store.start = text.end;
            store.anchored = true;
        }
        if (const std::string* size = fields.find({ "HeaderSize" })) {
            const std::int64_t bytes = integer_in(*size, "HeaderSize", where);
            if (bytes < -1 || (bytes != 0 && (store.anchored || store.encoding != Encoding::raw)))
                throw InputError("\"HeaderSize\" has no meaning here", where);
            store.at_end = bytes == -1;
            store.skip_bytes = bytes > 0 ? static_cast<std::uint64_t>(bytes) : 0;
        }
        return store;
    }

} // namespace

ImageHeader read_metaimage_header(const fs::path& path)
{
    ImageHeader header;
    header.where = path.string();
    const HeaderText text = read_text(path);
    const Fields fields(text.fields, header.where);
    if (const std::string* object = fields.find({ "ObjectType" }); object != nullptr && lower_case(*object) != "image")
        throw InputError("a MetaIO \"" + *object + "\" is no image", header.where);
    const std::int64_t dimensions = integer_in(fields.required("NDims"), "NDims", header.where);
    if (dimensions != 3)
        throw InputError("the image must be three-dimensional, it has " + std::to_string(dimensions) + " dimension(s)",
            header.where);
    if (const std::string* channels = fields.find({ "ElementNumberOfChannels" });
        channels != nullptr && integer_in(*channels, "ElementNumberOfChannels", header.where) != 1)
        throw InputError("the image must have one number per voxel, it has " + *channels, header.where);
    fields.required("DimSize");
    header.grid.size = checked_sizes(fields.numbers({ "DimSize" }, 3), header.where);
    set_geometry(fields, header);
    header.store = store_of(fields, text, path);
    if (const auto slope = fields.numbers({ "ElementToIntensityFunctionSlope" }, 1); !slope.empty())
        header.slope = slope[0];
    if (const auto offset = fields.numbers({ "ElementToIntensityFunctionOffset" }, 1); !offset.empty())
        header.intercept = offset[0];
    if (!std::isfinite(header.slope) || header.slope == 0.0 || !std::isfinite(header.intercept))
        throw InputError("\"ElementToIntensityFunction\" must be finite, its slope not 0", header.where);
    return header;
}

} // namespace retractor::datasets
