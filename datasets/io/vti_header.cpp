#include "datasets/io/vti_header.h"

#include "datasets/io/byte_source.h"
#include "datasets/io/header_text.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <optional>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    struct Element {
        std::string name; ///< an end tag has a slash: "/Piece"
        std::map<std::string, std::string> attributes;
        std::uint64_t content = 0; ///< offset in the file after the tag's ">"

        const std::string* find(const char* attribute) const
        {
            const auto found = attributes.find(attribute);
            return found == attributes.end() ? nullptr : &found->second;
        }
        std::string text(const char* attribute, const char* otherwise) const
        {
            const std::string* value = find(attribute);
            return value == nullptr ? otherwise : *value;
        }
    };

    /// Reads the tags of the file in order and skips the text between them.
    class TagReader {
    public:
        explicit TagReader(const fs::path& path)
            : file_(path, std::ios::binary)
            , where_(path.string())
        {
            if (!file_)
                throw IoError("cannot open the file", where_);
        }
        /// The next tag, or nothing at the end of the file.
        std::optional<Element> next()
        {
            for (;;) {
                int c = take();
                while (c >= 0 && c != '<')
                    c = take();
                if (c < 0)
                    return {};
                std::string tag = tag_text();
                if (tag.starts_with('?') || tag.starts_with('!'))
                    continue;
                return parsed(tag);
            }
        }

    private:
        int take()
        {
            const int c = file_.rdbuf()->sbumpc();
            at_ += c >= 0 ? 1 : 0;
            return c;
        }
        std::string tag_text()
        {
            constexpr std::size_t kLongest = 1U << 16U;
            std::string tag;
            char quote = 0;
            for (;;) {
                const int c = take();
                if (c <= 0 || tag.size() > kLongest)
                    throw InputError("not a readable .vti: a tag does not end", where_);
                const bool comment = tag.starts_with("!--");
                if (c == '>' && quote == 0 && (!comment || tag.ends_with("--")))
                    return tag;
                if (!comment && (c == '"' || c == '\''))
                    quote = quote == 0 ? static_cast<char>(c) : quote == c ? '\0' : quote;
                tag.push_back(static_cast<char>(c));
            }
        }
        Element parsed(const std::string& tag) const
        {
            Element element;
            element.content = at_;
            std::size_t at = std::min(tag.find_first_of(" \t\r\n/", 1), tag.size());
            element.name = tag.substr(0, at);
            while ((at = tag.find_first_not_of(" \t\r\n/", at)) != std::string::npos) {
                const std::size_t equals = tag.find('=', at);
                const std::size_t open = tag.find_first_of("\"'", at);
                if (equals == std::string::npos || open == std::string::npos || open < equals)
                    throw InputError(
                        "not a readable .vti: the element " + element.name.substr(0, 40) + " is damaged", where_);
                const std::size_t close = tag.find(tag[open], open + 1);
                if (close == std::string::npos)
                    throw InputError(
                        "not a readable .vti: the element " + element.name.substr(0, 40) + " is damaged", where_);
                element.attributes[trimmed(tag.substr(at, equals - at))] = tag.substr(open + 1, close - open - 1);
                at = close + 1;
            }
            return element;
        }

        std::ifstream file_;
        std::string where_;
        std::uint64_t at_ = 0;
    };

    /// The elements that describe the image, at any place of the document.
    struct Document {
        Element file;
        Element image;
        Element point_data;
        Element appended;
        std::vector<Element> pieces;
        std::vector<Element> arrays; ///< arrays of PointData
        bool cell_arrays = false;
    };

    Document read_document(const fs::path& path)
    {
        Document document;
        TagReader tags(path);
        std::string inside;
        while (const std::optional<Element> element = tags.next()) {
            if (element->name == "VTKFile")
                document.file = *element;
            else if (element->name == "ImageData")
                document.image = *element;
            else if (element->name == "Piece")
                document.pieces.push_back(*element);
            else if (element->name == "PointData" || element->name == "CellData" || element->name == "FieldData")
                inside = element->name;
            else if (element->name.starts_with('/') && element->name.ends_with("Data"))
                inside.clear();
            if (element->name == "PointData")
                document.point_data = *element;
            if (element->name == "DataArray" && inside == "PointData")
                document.arrays.push_back(*element);
            document.cell_arrays = document.cell_arrays || (element->name == "DataArray" && inside == "CellData");
            if (element->name == "AppendedData") { // the appended data may be binary
                document.appended = *element;
                break;
            }
        }
        const std::string where = path.string();
        if (document.file.name.empty() || document.file.text("type", "") != "ImageData" || document.image.name.empty())
            throw InputError("not a readable .vti: it has no VTKFile of type ImageData", where);
        if (document.pieces.size() != 1)
            throw InputError("the .vti must have one piece, it has " + std::to_string(document.pieces.size()), where);
        return document;
    }

    const Element& image_array(const Document& document, const std::string& where)
    {
        if (document.arrays.empty())
            throw InputError(document.cell_arrays ? "the .vti has its values in cells: convert them to point data"
                                                  : "the .vti has no values",
                where);
        const std::string scalars = document.point_data.text("Scalars", "");
        std::string names;
        for (const Element& array : document.arrays) {
            if (!scalars.empty() && array.text("Name", "") == scalars)
                return array;
            names += (names.empty() ? "" : ", ") + array.text("Name", "?");
        }
        if (document.arrays.size() == 1 && scalars.empty())
            return document.arrays.front();
        throw InputError("the .vti has several arrays and marks none as scalars: " + names, where);
    }

    std::vector<double> required(const Element& element, const char* name, std::size_t count, const std::string& where)
    {
        const std::string* text = element.find(name);
        if (text == nullptr)
            throw InputError("the element " + element.name + " has no " + name, where);
        std::vector<double> numbers = numbers_in(*text, name, where);
        if (numbers.size() != count)
            throw InputError(std::string("\"") + name + "\" must have " + std::to_string(count) + " numbers", where);
        return numbers;
    }

    void set_geometry(ImageHeader& header, const Document& document)
    {
        const std::string& where = header.where;
        const std::vector<double> extent = required(document.image, "WholeExtent", 6, where);
        if (required(document.pieces.front(), "Extent", 6, where) != extent)
            throw InputError("the piece of the .vti is not the whole extent", where);
        header.grid.size
            = checked_sizes({ extent[1] - extent[0] + 1, extent[3] - extent[2] + 1, extent[5] - extent[4] + 1 }, where);
        const std::vector<double> spacing = required(document.image, "Spacing", 3, where);
        const std::vector<double> origin = required(document.image, "Origin", 3, where);
        Mat3 steps = Mat3::Identity();
        if (document.image.find("Direction") != nullptr) {
            const std::vector<double> direction = required(document.image, "Direction", 9, where);
            for (std::size_t m = 0; m < 9; ++m) // the matrix is listed row by row
                steps(static_cast<Eigen::Index>(m / 3), static_cast<Eigen::Index>(m % 3)) = direction[m];
        }
        constexpr double kUnit = 1e-4; // as in check_grid()
        for (int a = 0; a < 3; ++a) {
            if (!(spacing[static_cast<std::size_t>(a)] > 0.0))
                throw InputError("the spacing of the .vti must be positive", where);
            if (!(std::abs(steps.col(a).norm() - 1.0) <= kUnit))
                throw InputError("the axes of \"Direction\" must be unit vectors", where);
            steps.col(a) *= spacing[static_cast<std::size_t>(a)];
        }
        set_steps(header.grid, steps, where);
        const Vec3 first(extent[0], extent[2], extent[4]);
        header.grid.origin = Vec3(origin[0], origin[1], origin[2]) + steps * first;
        if (!header.grid.origin.allFinite())
            throw InputError("the origin of the .vti must be finite", where);
    }

    VoxelType type_of(const std::string& text, const std::string& where)
    {
        static const std::map<std::string, VoxelType> kTypes { { "Int8", VoxelType::int8 },
            { "UInt8", VoxelType::uint8 }, { "Int16", VoxelType::int16 }, { "UInt16", VoxelType::uint16 },
            { "Int32", VoxelType::int32 }, { "UInt32", VoxelType::uint32 }, { "Int64", VoxelType::int64 },
            { "UInt64", VoxelType::uint64 }, { "Float32", VoxelType::float32 }, { "Float64", VoxelType::float64 } };
        const auto found = kTypes.find(text);
        if (found == kTypes.end())
            throw InputError("the .vti's values are no numbers (\"" + text.substr(0, 40) + "\")", where);
        return found->second;
    }

    /// The byte counts that VTK writes before data.
    class Counts {
    public:
        Counts(const Element& file, const VoxelStore& store, const std::string& where)
            : wide_(file.text("header_type", "UInt32") == "UInt64")
            , where_(where)
        {
            bytes_ = { store.files.front() };
            bytes_.start = store.start;
            bytes_.base64 = store.base64;
            swap_ = store.big_endian != (std::endian::native == std::endian::big);
            if (!wide_ && file.text("header_type", "UInt32") != "UInt32")
                throw InputError("the header_type of a .vti must be UInt32 or UInt64", where);
        }
        std::uint64_t size(std::uint64_t numbers) const { return numbers * (wide_ ? 8 : 4); }
        std::vector<std::uint64_t> read(std::uint64_t numbers) const
        {
            std::vector<char> raw(size(numbers));
            if (open_source(bytes_)->read(raw.data(), raw.size()) < raw.size())
                throw InputError("the .vti is cut short: its data have no byte count", where_);
            std::vector<std::uint64_t> values;
            const std::size_t width = size(1);
            for (std::size_t at = 0; at < raw.size(); at += width) {
                if (swap_)
                    std::reverse(raw.data() + at, raw.data() + at + width);
                std::uint32_t narrow = 0;
                std::uint64_t value = 0;
                std::memcpy(wide_ ? static_cast<void*>(&value) : &narrow, raw.data() + at, width);
                values.push_back(wide_ ? value : narrow);
            }
            return values;
        }

    private:
        bool wide_;
        bool swap_ = false;
        EncodedBytes bytes_;
        std::string where_;
    };

    [[noreturn]] void throw_sizes(std::uint64_t promised, std::uint64_t stored, const std::string& where)
    {
        throw InputError("the .vti is cut short or contradicts itself: the extent promises " + std::to_string(promised)
                + " bytes, the data " + std::to_string(stored),
            where);
    }

    /// Uncompressed data: one count, then the bytes.
    void set_plain(VoxelStore& store, const Counts& counts, std::uint64_t promised, const std::string& where)
    {
        const std::uint64_t stored = counts.read(1).front();
        if (stored != promised)
            throw_sizes(promised, stored, where);
        const std::uint64_t all = counts.size(1) + stored;
        store.skip_bytes = counts.size(1);
        store.length = store.base64 ? (all + 2) / 3 * 4 : all;
    }

    /// Compressed data: number of blocks, size of a block, size of a smaller last block, compressed size of each block,
    /// then the blocks.
    void set_packed(VoxelStore& store, const Counts& counts, std::uint64_t promised, const std::string& where)
    {
        const std::vector<std::uint64_t> first = counts.read(3);
        const std::uint64_t blocks = first[0];
        const std::uint64_t file_bytes = fs::file_size(store.files.front());
        if (blocks == 0 || blocks > file_bytes / 4 || first[1] > promised || first[2] > promised)
            throw_sizes(promised, blocks == 0 ? 0 : first[1], where);
        const std::uint64_t unpacked = (blocks - (first[2] > 0 ? 1 : 0)) * first[1] + first[2];
        if (unpacked != promised)
            throw_sizes(promised, unpacked, where);
        const std::vector<std::uint64_t> all = counts.read(3 + blocks);
        std::uint64_t packed = 0;
        for (std::size_t n = 3; n < all.size(); ++n) {
            if (all[n] > file_bytes)
                throw_sizes(promised, unpacked, where);
            packed += all[n];
        }
        const std::uint64_t ahead = counts.size(3 + blocks);
        store.start += store.base64 ? (ahead + 2) / 3 * 4 : ahead; // the counts are encoded apart from the blocks
        store.length = store.base64 ? (packed + 2) / 3 * 4 : packed;
        store.encoding = Encoding::deflate;
        store.streams = blocks;
    }

    /// Offset of the first character from `start` on that is not blank, or, with `tag`, of the first "<".
    std::uint64_t find_character(const fs::path& path, std::uint64_t start, bool tag)
    {
        std::ifstream file(path, std::ios::binary);
        file.seekg(static_cast<std::streamoff>(start));
        std::streambuf& bytes = *file.rdbuf();
        for (int c = bytes.sbumpc(); c >= 0; c = bytes.sbumpc(), ++start)
            if (tag ? c == '<' : !(c == ' ' || (c >= '\t' && c <= '\r')))
                break;
        return start;
    }

    void set_store(ImageHeader& header, const Document& document, const Element& array)
    {
        const std::string& where = header.where;
        VoxelStore& store = header.store;
        const fs::path& path = store.files.front();
        store.type = type_of(array.text("type", ""), where);
        const std::string order = document.file.text("byte_order", "LittleEndian");
        if (order != "LittleEndian" && order != "BigEndian")
            throw InputError("the byte_order of a .vti must be LittleEndian or BigEndian", where);
        store.big_endian = order == "BigEndian";
        store.anchored = true;
        const std::string format = array.text("format", "ascii");
        if (format == "ascii") {
            store.encoding = Encoding::text;
            store.big_endian = std::endian::native == std::endian::big;
            store.start = array.content;
            store.length = find_character(path, store.start, true) - store.start;
            return;
        }
        if (format == "binary") {
            store.base64 = true;
            store.start = find_character(path, array.content, false);
        } else if (format == "appended" && !document.appended.name.empty()) {
            const std::int64_t offset = integer_in(array.text("offset", ""), "offset", where);
            const std::uint64_t size = fs::file_size(path);
            if (offset < 0 || static_cast<std::uint64_t>(offset) > size)
                throw InputError("the offset of the .vti's data lies outside the file", where);
            const std::string encoding = document.appended.text("encoding", "base64");
            if (encoding != "raw" && encoding != "base64")
                throw InputError("the encoding of appended data must be raw or base64", where);
            store.base64 = encoding == "base64";
            // The appended data begin after an underscore.
            store.start
                = find_character(path, document.appended.content, false) + 1 + static_cast<std::uint64_t>(offset);
        } else {
            throw InputError("the .vti's values have the format \"" + format.substr(0, 40) + "\" and no data", where);
        }
        const Counts counts(document.file, store, where);
        const std::uint64_t promised = header.grid.voxel_count() * voxel_bytes(store.type);
        const std::string compressor = document.file.text("compressor", "");
        if (compressor.empty())
            set_plain(store, counts, promised, where);
        else if (compressor == "vtkZLibDataCompressor")
            set_packed(store, counts, promised, where);
        else
            throw InputError(
                "the compressor \"" + compressor.substr(0, 40) + "\" is not read: use zlib or none", where);
    }

} // namespace

ImageHeader read_vti_header(const fs::path& path)
{
    ImageHeader header;
    header.where = path.string();
    header.store.files = { path };
    const Document document = read_document(path);
    set_geometry(header, document);
    const Element& array = image_array(document, header.where);
    if (const std::string components = trimmed(array.text("NumberOfComponents", "1")); components != "1")
        throw InputError("the image must have one number per voxel, it has " + components.substr(0, 40), header.where);
    set_store(header, document, array);
    header.notes.emplace_back("a .vti names no frame and no unit: taken as patient LPS in mm");
    return header;
}

} // namespace retractor::datasets
