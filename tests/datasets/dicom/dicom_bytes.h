#pragma once
// DICOM files written byte by byte (explicit VR, little endian), so that tests can make files that a correct writer
// refuses to make.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace retractor::test_support {

/// A data set: elements by tag, written in the order of tags. Setting a tag again replaces its element.
class DicomBytes {
public:
    DicomBytes& text(std::uint32_t tag, const char* vr, std::string value)
    {
        if (value.size() % 2 != 0)
            value += std::string(vr) == "UI" ? '\0' : ' ';
        return raw(tag, vr, value);
    }
    DicomBytes& u16(std::uint32_t tag, int value) { return raw(tag, "US", number(value, 2)); }
    DicomBytes& s16(std::uint32_t tag, int value) { return raw(tag, "SS", number(value, 2)); }
    DicomBytes& u32(std::uint32_t tag, std::uint32_t value) { return raw(tag, "UL", number(value, 4)); }
    DicomBytes& raw(std::uint32_t tag, const char* vr, const std::string& value)
    {
        const std::string kind = vr;
        const bool is_long = kind == "OB" || kind == "OW" || kind == "SQ" || kind == "UN" || kind == "UT";
        elements_[tag] = header(tag) + kind
            + (is_long ? std::string(2, '\0') + number(static_cast<std::int64_t>(value.size()), 4)
                       : number(static_cast<std::int64_t>(value.size()), 2))
            + value;
        return *this;
    }
    DicomBytes& sequence(std::uint32_t tag, const std::vector<DicomBytes>& items)
    {
        std::string value;
        for (const DicomBytes& item : items) {
            const std::string bytes = item.bytes();
            value += header(0xFFFEE000) + number(static_cast<std::int64_t>(bytes.size()), 4) + bytes;
        }
        return raw(tag, "SQ", value);
    }
    /// Compressed pixels: the table of offsets, then the fragments.
    DicomBytes& fragments(std::uint32_t tag, const std::vector<std::string>& items)
    {
        std::string all = header(tag) + "OB" + std::string(2, '\0') + number(0xFFFFFFFF, 4);
        for (const std::string& item : items)
            all += header(0xFFFEE000) + number(static_cast<std::int64_t>(item.size()), 4) + item;
        elements_[tag] = all + header(0xFFFEE0DD) + number(0, 4);
        return *this;
    }
    DicomBytes& erase(std::uint32_t tag)
    {
        elements_.erase(tag);
        return *this;
    }
    std::string bytes() const
    {
        std::string all;
        for (const auto& [tag, element] : elements_)
            all += element;
        return all;
    }
    static std::string number(std::int64_t value, int size)
    {
        std::string bytes;
        for (int b = 0; b < size; ++b)
            bytes += static_cast<char>((value >> (8 * b)) & 0xFF);
        return bytes;
    }

private:
    static std::string header(std::uint32_t tag) { return number(tag >> 16, 2) + number(tag & 0xFFFF, 2); }
    std::map<std::uint32_t, std::string> elements_;
};

inline constexpr const char* kCtStorage = "1.2.840.10008.5.1.4.1.1.2";
inline constexpr const char* kEnhancedCtStorage = "1.2.840.10008.5.1.4.1.1.2.1";

/// The bytes of a file: preamble, meta header and data set.
inline std::string dicom_file(const DicomBytes& data, const std::string& sop_class = kCtStorage,
    const std::string& transfer_syntax = "1.2.840.10008.1.2.1")
{
    DicomBytes meta;
    meta.raw(0x00020001, "OB", std::string("\0\1", 2));
    meta.text(0x00020002, "UI", sop_class);
    meta.text(0x00020003, "UI", "1.2.3");
    meta.text(0x00020010, "UI", transfer_syntax);
    meta.text(0x00020012, "UI", "1.2.3.4");
    DicomBytes length;
    length.u32(0x00020000, static_cast<std::uint32_t>(meta.bytes().size()));
    return std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + data.bytes();
}

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes)
{
    std::filesystem::create_directories(path.parent_path());
    std::filesystem::remove(path); // with overwriting, some file systems wait for the disk
    std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string pixel_bytes(const std::vector<int>& stored)
{
    std::string bytes;
    for (const int value : stored)
        bytes += DicomBytes::number(value, 2);
    return bytes;
}

inline constexpr int kTestColumns = 6;
inline constexpr int kTestRows = 5;

inline std::string position_text(double x, double y, double z)
{
    char text[64];
    std::snprintf(text, sizeof text, "%.9g\\%.9g\\%.9g", x, y, z);
    return text;
}

/// A valid CT slice of 6 x 5 pixels of 0.5 x 0.5 mm. The stored value is 1000 + column + 10 row + 100 (z rounded), and
/// the intercept is -1024. Each slice has a SOP instance UID of its own.
inline DicomBytes ct_slice(double z, int instance)
{
    DicomBytes d;
    d.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL");
    d.text(0x00080016, "UI", kCtStorage);
    static int unique = 0;
    d.text(0x00080018, "UI", "1.2.826.1." + std::to_string(++unique));
    d.text(0x00080060, "CS", "CT");
    d.text(0x0008103E, "LO", "Thorax");
    d.text(0x00100010, "PN", "Secret^Person");
    d.text(0x00100020, "LO", "PID-4711");
    d.text(0x00180050, "DS", "2");
    d.text(0x0020000D, "UI", "1.2.3.7");
    d.text(0x0020000E, "UI", "1.2.3.8");
    d.text(0x00200011, "IS", "4");
    d.text(0x00200013, "IS", std::to_string(instance));
    d.text(0x00200032, "DS", position_text(-10.0, 20.0, z));
    d.text(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    d.u16(0x00280002, 1);
    d.text(0x00280004, "CS", "MONOCHROME2");
    d.u16(0x00280010, kTestRows);
    d.u16(0x00280011, kTestColumns);
    d.text(0x00280030, "DS", "0.5\\0.5");
    d.u16(0x00280100, 16);
    d.u16(0x00280101, 16);
    d.u16(0x00280102, 15);
    d.u16(0x00280103, 0);
    d.text(0x00281052, "DS", "-1024");
    d.text(0x00281053, "DS", "1");
    std::vector<int> stored;
    for (int j = 0; j < kTestRows; ++j)
        for (int i = 0; i < kTestColumns; ++i)
            stored.push_back(1000 + i + 10 * j + 100 * static_cast<int>(std::lround(z)));
    d.raw(0x7FE00010, "OW", pixel_bytes(stored));
    return d;
}

inline void write_slice(const std::filesystem::path& path, const DicomBytes& slice)
{
    write_bytes(path, dicom_file(slice));
}

/// Writes `count` valid slices 2 mm apart, beginning with 01.dcm at z = 0.
inline void write_stack(const std::filesystem::path& folder, int count,
    const std::function<void(DicomBytes&, int)>& change = {}, const std::string& prefix = "")
{
    for (int s = 0; s < count; ++s) {
        DicomBytes slice = ct_slice(2.0 * s, s + 1);
        if (change)
            change(slice, s);
        char name[32];
        std::snprintf(name, sizeof name, "%02d.dcm", s + 1);
        write_slice(folder / (prefix + name), slice);
    }
}

/// An enhanced CT with frames in the given order; frames share their geometry where DICOM allows sharing.
inline DicomBytes enhanced_ct(
    const std::vector<double>& heights, const std::vector<double>& slopes, bool phases = false)
{
    DicomBytes d = ct_slice(0.0, 1);
    d.text(0x00080016, "UI", kEnhancedCtStorage);
    for (const std::uint32_t per_frame :
        { 0x00200032U, 0x00200037U, 0x00280030U, 0x00281052U, 0x00281053U, 0x00180050U })
        d.erase(per_frame);
    d.text(0x00280008, "IS", std::to_string(heights.size()));
    DicomBytes orientation;
    orientation.text(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    DicomBytes measures;
    measures.text(0x00280030, "DS", "0.5\\0.5").text(0x00180050, "DS", "3");
    DicomBytes shared;
    shared.sequence(0x00209116, { orientation }).sequence(0x00289110, { measures });
    std::vector<DicomBytes> frames;
    std::string pixels;
    for (std::size_t f = 0; f < heights.size(); ++f) {
        DicomBytes position;
        position.text(0x00200032, "DS", position_text(-10.0, 20.0, heights[f]));
        DicomBytes transformation;
        transformation.text(0x00281052, "DS", "-1024").text(0x00281053, "DS", std::to_string(slopes[f]));
        transformation.text(0x00281054, "LO", "HU");
        DicomBytes content;
        content.u32(0x00209128, phases ? static_cast<std::uint32_t>(f % 2 + 1) : 1);
        frames.push_back(DicomBytes()
                             .sequence(0x00209111, { content })
                             .sequence(0x00209113, { position })
                             .sequence(0x00289145, { transformation }));
        std::vector<int> stored;
        for (int p = 0; p < kTestColumns * kTestRows; ++p)
            stored.push_back(1000 + p + 100 * static_cast<int>(heights[f]));
        pixels += pixel_bytes(stored);
    }
    d.sequence(0x52009229, { shared }).sequence(0x52009230, frames);
    return d.raw(0x7FE00010, "OW", pixels);
}

} // namespace retractor::test_support
