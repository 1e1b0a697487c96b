#include "datasets/io/nrrd_header.h"

#include "datasets/io/header_text.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <optional>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    using Fields = std::map<std::string, std::string>;

    /// The fields of a header, and the offset of its end.
    struct HeaderText {
        Fields fields; ///< names in lower case without blanks: "spacedirections"
        std::map<std::string, std::string> keys;
        std::vector<fs::path> data_files; ///< empty when the data follow the header
        std::uint64_t end = 0;
    };

    std::string field_name(std::string_view text)
    {
        std::string name = lower_case(trimmed(text));
        std::erase(name, ' ');
        return name == "centerings" ? "centers" : name;
    }

    HeaderText read_text(const fs::path& path)
    {
        const std::string where = path.string();
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw IoError("cannot open the file", where);
        std::string line;
        if (!next_header_line(file, line, where) || line.size() != 8 || !line.starts_with("NRRD000") || line[7] < '1'
            || line[7] > '5')
            throw InputError("not an NRRD file (it must begin with NRRD0001 to NRRD0005)", where);
        HeaderText header;
        bool blank = false;
        while (!blank && next_header_line(file, line, where)) {
            blank = line.empty();
            if (blank || line.front() == '#')
                continue;
            const std::size_t colon = line.find(':');
            if (colon == std::string::npos)
                throw InputError(
                    "the header has a line that is no field (is the blank line missing that ends it?)", where);
            if (line.compare(colon, 2, ":=") == 0) {
                header.keys[line.substr(0, colon)] = line.substr(colon + 2);
                continue;
            }
            const std::string name = field_name(line.substr(0, colon));
            if (!header.fields.emplace(name, trimmed(line.substr(colon + 1))).second)
                throw InputError("the field \"" + name + "\" is given twice", where);
            if (name == "datafile") {
                const std::string value = header.fields[name];
                header.data_files = data_files(path, value, file);
                if (value.starts_with("LIST"))
                    return header; // the list of files ends the header
            }
        }
        if (!blank && header.data_files.empty())
            throw InputError("no blank line ends the header: there are no voxels", where);
        header.end = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file.tellg()));
        return header;
    }

    const std::string& required(const Fields& fields, const char* name, const std::string& where)
    {
        const auto found = fields.find(name);
        if (found == fields.end())
            throw InputError(std::string("the header has no field \"") + name + "\"", where);
        return found->second;
    }

    const std::string* optional_field(const Fields& fields, const char* name)
    {
        const auto found = fields.find(name);
        return found == fields.end() ? nullptr : &found->second;
    }

    VoxelType type_of(const std::string& text, const std::string& where)
    {
        static const std::map<std::string, VoxelType> kTypes { { "signed char", VoxelType::int8 },
            { "int8", VoxelType::int8 }, { "int8_t", VoxelType::int8 }, { "uchar", VoxelType::uint8 },
            { "unsigned char", VoxelType::uint8 }, { "uint8", VoxelType::uint8 }, { "uint8_t", VoxelType::uint8 },
            { "short", VoxelType::int16 }, { "short int", VoxelType::int16 }, { "signed short", VoxelType::int16 },
            { "signed short int", VoxelType::int16 }, { "int16", VoxelType::int16 }, { "int16_t", VoxelType::int16 },
            { "ushort", VoxelType::uint16 }, { "unsigned short", VoxelType::uint16 },
            { "unsigned short int", VoxelType::uint16 }, { "uint16", VoxelType::uint16 },
            { "uint16_t", VoxelType::uint16 }, { "int", VoxelType::int32 }, { "signed int", VoxelType::int32 },
            { "int32", VoxelType::int32 }, { "int32_t", VoxelType::int32 }, { "uint", VoxelType::uint32 },
            { "unsigned int", VoxelType::uint32 }, { "uint32", VoxelType::uint32 }, { "uint32_t", VoxelType::uint32 },
            { "longlong", VoxelType::int64 }, { "long long", VoxelType::int64 }, { "long long int", VoxelType::int64 },
            { "signed long long", VoxelType::int64 }, { "signed long long int", VoxelType::int64 },
            { "int64", VoxelType::int64 }, { "int64_t", VoxelType::int64 }, { "ulonglong", VoxelType::uint64 },
            { "unsigned long long", VoxelType::uint64 }, { "unsigned long long int", VoxelType::uint64 },
            { "uint64", VoxelType::uint64 }, { "uint64_t", VoxelType::uint64 }, { "float", VoxelType::float32 },
            { "double", VoxelType::float64 } };
        const auto found = kTypes.find(lower_case(text));
        if (found == kTypes.end())
            throw InputError("the type \"" + text + "\" is not one number per voxel", where);
        return found->second;
    }

    Encoding encoding_of(const std::string& text, const std::string& where)
    {
        static const std::map<std::string, Encoding> kEncodings { { "raw", Encoding::raw }, { "txt", Encoding::text },
            { "text", Encoding::text }, { "ascii", Encoding::text }, { "hex", Encoding::hex },
            { "gz", Encoding::deflate }, { "gzip", Encoding::deflate }, { "bz2", Encoding::bzip2 },
            { "bzip2", Encoding::bzip2 } };
        const auto found = kEncodings.find(lower_case(text));
        if (found == kEncodings.end())
            throw InputError("the encoding \"" + text + "\" is not read: use raw, gzip, bzip2, text or hex", where);
        return found->second;
    }

    /// The signs of x, y, z that convert the header's space to LPS.
    Vec3 signs_of_space(const Fields& fields, std::vector<std::string>& notes, const std::string& where)
    {
        const std::string* space = optional_field(fields, "space");
        if (space == nullptr) {
            notes.push_back("the header names no space: taken as patient LPS (x to the left, y to the back, z up)");
            return Vec3::Ones();
        }
        static const std::map<std::string, Vec3> kSpaces { { "left-posterior-superior", Vec3(1, 1, 1) },
            { "lps", Vec3(1, 1, 1) }, { "right-anterior-superior", Vec3(-1, -1, 1) }, { "ras", Vec3(-1, -1, 1) },
            { "left-anterior-superior", Vec3(1, -1, 1) }, { "las", Vec3(1, -1, 1) } };
        const auto found = kSpaces.find(lower_case(*space));
        if (found == kSpaces.end())
            throw InputError("the space \"" + *space + "\" is no patient frame: use LPS, RAS or LAS", where);
        return found->second;
    }

    /// Parses "(1,0,0) none (0, 1, 0)"; "none" gives no vector.
    std::vector<std::optional<Vec3>> vectors_in(
        const std::string& text, const std::string& field, const std::string& where)
    {
        std::vector<std::optional<Vec3>> vectors;
        std::size_t at = 0;
        while ((at = text.find_first_not_of(" \t", at)) != std::string::npos) {
            if (lower_case(text.substr(at, 4)) == "none") {
                vectors.emplace_back();
                at += 4;
                continue;
            }
            const std::size_t end = text.find(')', at);
            if (text[at] != '(' || end == std::string::npos)
                throw InputError("\"" + field + "\" must be vectors such as (1,0,0)", where);
            std::string inside = text.substr(at + 1, end - at - 1);
            std::replace(inside.begin(), inside.end(), ',', ' ');
            const std::vector<double> numbers = numbers_in(inside, field, where);
            if (numbers.size() != 3)
                throw InputError("\"" + field + "\" must have three numbers in each vector", where);
            vectors.emplace_back(Vec3(numbers[0], numbers[1], numbers[2]));
            at = end + 1;
        }
        return vectors;
    }

    /// Checks the quoted units. Only millimetres are accepted.
    void check_units(const Fields& fields, const char* field, const std::string& where)
    {
        const std::string* text = optional_field(fields, field);
        if (text == nullptr)
            return;
        std::size_t at = 0;
        while ((at = text->find('"', at)) != std::string::npos) {
            const std::size_t end = std::min(text->find('"', at + 1), text->size());
            const std::string unit = lower_case(trimmed(text->substr(at + 1, end - at - 1)));
            if (!unit.empty() && unit != "mm" && unit != "millimeter" && unit != "millimetre")
                throw InputError("the unit \"" + unit + "\" of \"" + field + "\" is not read: use mm", where);
            at = end + 1;
        }
    }

    /// Index of the first spatial axis: 1 when a list of numbers per voxel comes first, else 0.
    std::size_t first_spatial_axis(const Fields& fields, std::size_t dimension, const std::string& where)
    {
        const std::string* kinds = optional_field(fields, "kinds");
        std::vector<std::string> kind = words_of(kinds == nullptr ? "" : lower_case(*kinds));
        if (kinds != nullptr && kind.size() != dimension)
            throw InputError("\"kinds\" must have one entry per axis", where);
        std::vector<bool> spatial(dimension, true);
        for (std::size_t a = 0; a < kind.size(); ++a)
            spatial[a] = kind[a] == "domain" || kind[a] == "space" || kind[a] == "???" || kind[a] == "none";
        if (const std::string* directions = optional_field(fields, "spacedirections")) {
            const auto vectors = vectors_in(*directions, "space directions", where);
            if (vectors.size() != dimension)
                throw InputError("\"space directions\" must have one entry per axis", where);
            for (std::size_t a = 0; a < dimension; ++a)
                spatial[a] = spatial[a] && vectors[a].has_value();
        }
        const auto count = static_cast<std::size_t>(std::count(spatial.begin(), spatial.end(), true));
        if (dimension == 3 && count == 3)
            return 0;
        if (dimension == 4 && count == 3 && !spatial[0])
            return 1;
        throw InputError("the image must be three-dimensional, it has " + std::to_string(dimension) + " dimension(s), "
                + std::to_string(count) + " of them in space",
            where);
    }

    void set_geometry(ImageHeader& header, const Fields& fields, std::size_t first)
    {
        const std::string& where = header.where;
        const Vec3 signs = signs_of_space(fields, header.notes, where);
        Mat3 steps = Mat3::Zero();
        if (const std::string* directions = optional_field(fields, "spacedirections")) {
            const auto vectors = vectors_in(*directions, "space directions", where);
            for (std::size_t a = 0; a < 3; ++a)
                steps.col(static_cast<Eigen::Index>(a)) = *vectors[first + a];
        } else if (const std::string* text = optional_field(fields, "spacings")) {
            const std::vector<double> spacings = numbers_in(*text, "spacings", where);
            if (spacings.size() != first + 3)
                throw InputError("\"spacings\" must have one entry per axis", where);
            for (std::size_t a = 0; a < 3; ++a) {
                if (!(spacings[first + a] > 0.0))
                    throw InputError("\"spacings\" must be positive", where);
                steps(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(a)) = spacings[first + a];
            }
        } else {
            throw InputError("the header has neither \"space directions\" nor \"spacings\"", where);
        }
        set_steps(header.grid, signs.asDiagonal() * steps, where);
        if (const std::string* origin = optional_field(fields, "spaceorigin")) {
            const auto vectors = vectors_in(*origin, "space origin", where);
            if (vectors.size() != 1 || !vectors[0] || !vectors[0]->allFinite())
                throw InputError("\"space origin\" must be one finite vector", where);
            header.grid.origin = signs.cwiseProduct(*vectors[0]);
        } else {
            header.notes.push_back("the header names no origin: taken as (0, 0, 0)");
        }
    }

    void set_skips(VoxelStore& store, const Fields& fields, const std::string& where)
    {
        for (const char* name : { "lineskip", "byteskip" }) {
            const std::string* text = optional_field(fields, name);
            if (text == nullptr)
                continue;
            const std::int64_t count = integer_in(*text, name, where);
            const bool bytes = std::string(name) == "byteskip";
            if (bytes && count == -1)
                store.at_end = true;
            else if (count < 0)
                throw InputError("\"" + std::string(name) + "\" must not be negative"
                        + (bytes ? " (but for -1: the data are the last bytes)" : ""),
                    where);
            else
                (bytes ? store.skip_bytes : store.skip_lines) = static_cast<std::uint64_t>(count);
        }
        if (store.at_end && (store.encoding == Encoding::text || store.encoding == Encoding::hex))
            throw InputError("\"byteskip\" -1 has no meaning in text", where);
    }

    VoxelStore store_of(const HeaderText& text, const fs::path& path)
    {
        const std::string where = path.string();
        VoxelStore store;
        store.type = type_of(required(text.fields, "type", where), where);
        store.encoding = encoding_of(required(text.fields, "encoding", where), where);
        store.files = text.data_files;
        if (store.files.empty()) {
            store.files = { path };
            store.start = text.end;
            store.anchored = true;
        }
        set_skips(store, text.fields, where);
        const std::string* endian = optional_field(text.fields, "endian");
        if (endian != nullptr && lower_case(*endian) != "little" && lower_case(*endian) != "big")
            throw InputError("\"endian\" must be little or big", where);
        if (store.encoding == Encoding::text)
            store.big_endian = std::endian::native == std::endian::big;
        else if (endian != nullptr)
            store.big_endian = lower_case(*endian) == "big";
        else if (voxel_bytes(store.type) > 1)
            throw InputError("the header does not name the byte order (\"endian\")", where);
        return store;
    }

} // namespace

ImageHeader read_nrrd_header(const fs::path& path)
{
    ImageHeader header;
    header.where = path.string();
    const HeaderText text = read_text(path);
    const Fields& fields = text.fields;
    const std::int64_t dimension = integer_in(required(fields, "dimension", header.where), "dimension", header.where);
    if (dimension < 1 || dimension > 16)
        throw InputError("\"dimension\" must be from 1 to 16", header.where);
    const std::vector<double> sizes = numbers_in(required(fields, "sizes", header.where), "sizes", header.where);
    if (sizes.size() != static_cast<std::size_t>(dimension))
        throw InputError("\"sizes\" must have one entry per axis", header.where);
    for (const char* quantised : { "oldmin", "oldmax" })
        if (fields.contains(quantised))
            throw InputError("the values were quantised (\"old min\", \"old max\"): they are not Hounsfield units or "
                             "labels any more",
                header.where);
    check_units(fields, "spaceunits", header.where);
    check_units(fields, "units", header.where);
    const std::size_t first = first_spatial_axis(fields, sizes.size(), header.where);
    header.grid.size = checked_sizes({ sizes.begin() + static_cast<std::ptrdiff_t>(first), sizes.end() }, header.where);
    if (first == 1) {
        constexpr double kMostComponents = 4096;
        if (!(sizes[0] >= 1.0 && sizes[0] <= kMostComponents) || sizes[0] != std::floor(sizes[0]))
            throw InputError("the size along axis 1 is out of range", header.where);
        header.components = static_cast<int>(sizes[0]);
    }
    set_geometry(header, fields, first);
    header.store = store_of(text, path);
    header.keys = text.keys;
    return header;
}

} // namespace retractor::datasets
