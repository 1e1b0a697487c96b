#include "datasets/file_checks.h"

#include "mesh/base/error.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace retractor {

namespace {

    std::string read_bytes(const std::filesystem::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw IoError("cannot open the file", path.string());
        return { std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>() };
    }

    /// Inflates a zlib or gzip stream, counting bytes and keeping the first of them; a damaged or short stream is
    /// refused.
    struct Inflated {
        std::string head;
        std::uint64_t size = 0;
    };
    Inflated inflate_all(const char* data, std::size_t size, const std::string& where)
    {
        constexpr std::size_t kHead = 1024;
        constexpr int kAnyFormat = 15 + 32; // largest window, zlib or gzip header
        z_stream stream {};
        if (inflateInit2(&stream, kAnyFormat) != Z_OK)
            throw IoError("cannot start decompression", where);
        std::vector<char> buffer(1U << 18U);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data));
        stream.avail_in = static_cast<uInt>(size);
        Inflated result;
        int status = Z_OK;
        while (status == Z_OK) {
            stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
            stream.avail_out = static_cast<uInt>(buffer.size());
            status = inflate(&stream, Z_NO_FLUSH);
            const std::size_t count = buffer.size() - stream.avail_out;
            if (result.head.size() < kHead)
                result.head.append(buffer.data(), std::min(count, kHead - result.head.size()));
            result.size += count;
        }
        inflateEnd(&stream);
        if (status != Z_STREAM_END)
            throw InputError("the compressed data are damaged or cut short", where);
        return result;
    }

    template <typename T> T field(const std::string& header, std::size_t at, bool swap)
    {
        std::array<char, sizeof(T)> bytes {};
        std::memcpy(bytes.data(), header.data() + at, sizeof(T));
        if (swap)
            std::reverse(bytes.begin(), bytes.end());
        return std::bit_cast<T>(bytes);
    }

    void check_nifti_type(int type, int bits, const std::string& where)
    {
        static const std::map<int, int> kBits { { 2, 8 }, { 4, 16 }, { 8, 32 }, { 16, 32 }, { 64, 64 }, { 256, 8 },
            { 512, 16 }, { 768, 32 }, { 1024, 64 }, { 1280, 64 } };
        const auto found = kBits.find(type);
        if (found == kBits.end())
            throw InputError("NIfTI datatype " + std::to_string(type) + " is not one number per voxel", where);
        if (found->second != bits)
            throw InputError(
                "NIfTI bitpix " + std::to_string(bits) + " contradicts datatype " + std::to_string(type), where);
    }

} // namespace

void check_nifti_file(const std::filesystem::path& path)
{
    constexpr std::size_t kHeader = 348;
    const std::string where = path.string();
    const std::string bytes = read_bytes(path);
    const bool gz = path.extension() == ".gz";
    Inflated data;
    if (gz) {
        if (bytes.size() < 2 || static_cast<unsigned char>(bytes[0]) != 0x1f
            || static_cast<unsigned char>(bytes[1]) != 0x8b)
            throw InputError("named .gz but not gzip-compressed", where);
        data = inflate_all(bytes.data(), bytes.size(), where);
    } else {
        data = { bytes.substr(0, kHeader), bytes.size() };
    }
    const std::string& header = data.head;
    if (header.size() < kHeader)
        throw InputError("the NIfTI header is cut short", where);
    const bool swap = field<std::int32_t>(header, 0, false) != static_cast<std::int32_t>(kHeader);
    if (field<std::int32_t>(header, 0, swap) != static_cast<std::int32_t>(kHeader))
        throw InputError("not a NIfTI-1 file", where);
    if (header.compare(344, 3, "n+1") != 0 && header.compare(344, 3, "ni1") != 0)
        throw InputError("not a NIfTI-1 file (its magic is missing)", where);
    check_nifti_type(field<std::int16_t>(header, 70, swap), field<std::int16_t>(header, 72, swap), where);
    double voxels = 1.0;
    const int dimensions = field<std::int16_t>(header, 40, swap);
    if (dimensions < 1 || dimensions > 7)
        throw InputError("NIfTI dim[0] is out of range", where);
    for (int d = 1; d <= dimensions; ++d) {
        const auto at = static_cast<std::size_t>(d);
        const int n = field<std::int16_t>(header, 40 + 2 * at, swap);
        if (n < 1)
            throw InputError("NIfTI dim[" + std::to_string(d) + "] must be positive, got " + std::to_string(n), where);
        const float spacing = field<float>(header, 76 + 4 * at, swap);
        if (d <= 3 && !(std::isfinite(spacing) && spacing > 0.0F))
            throw InputError("NIfTI pixdim[" + std::to_string(d) + "] must be positive and finite", where);
        voxels *= n;
    }
    const double offset = field<float>(header, 108, swap);
    const double needed = offset + voxels * field<std::int16_t>(header, 72, swap) / 8.0;
    if (!(offset >= 0.0) || static_cast<double>(data.size) < needed)
        throw InputError("the file is cut short: the header promises "
                + std::to_string(static_cast<std::uint64_t>(needed)) + " bytes, there are " + std::to_string(data.size),
            where);
    if (!std::isfinite(field<float>(header, 112, swap)) || !std::isfinite(field<float>(header, 116, swap)))
        throw InputError("NIfTI scl_slope and scl_inter must be finite", where);
}

void check_metaimage_file(const std::filesystem::path& path)
{
    const std::string where = path.string();
    const std::string bytes = read_bytes(path);
    std::map<std::string, std::string> fields;
    std::size_t at = 0;
    while (at < bytes.size() && !fields.contains("ElementDataFile")) {
        const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
        const std::string line = bytes.substr(at, end - at);
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos)
            throw InputError("not a MetaImage header", where);
        const auto trim = [](const std::string& text) {
            const std::size_t first = text.find_first_not_of(" \t\r");
            return first == std::string::npos ? std::string()
                                              : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
        };
        fields[trim(line.substr(0, equals))] = trim(line.substr(equals + 1));
        at = end + 1;
    }
    if (!fields.contains("ElementDataFile"))
        throw InputError("the MetaImage header is cut short", where);
    if (fields["ElementDataFile"] != "LOCAL")
        return;
    static const std::map<std::string, int> kSizes { { "MET_CHAR", 1 }, { "MET_UCHAR", 1 }, { "MET_SHORT", 2 },
        { "MET_USHORT", 2 }, { "MET_INT", 4 }, { "MET_UINT", 4 }, { "MET_LONG", 4 }, { "MET_ULONG", 4 },
        { "MET_LONG_LONG", 8 }, { "MET_ULONG_LONG", 8 }, { "MET_FLOAT", 4 }, { "MET_DOUBLE", 8 } };
    const auto size = kSizes.find(fields["ElementType"]);
    if (size == kSizes.end())
        throw InputError("unknown ElementType \"" + fields["ElementType"] + "\"", where);
    double needed = size->second;
    std::istringstream dimensions(fields["DimSize"]);
    for (double n = 0.0; dimensions >> n;)
        needed *= n;
    const std::size_t stored = at < bytes.size() ? bytes.size() - at : 0;
    const bool compressed = fields["CompressedData"] == "True";
    const auto there = compressed ? static_cast<double>(inflate_all(bytes.data() + at, stored, where).size)
                                  : static_cast<double>(stored);
    if (there < needed)
        throw InputError("the file has fewer pixels than its header promises", where);
}

} // namespace retractor
