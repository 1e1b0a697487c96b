#include "planner/case/unsaved_labels.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "planner/case/checked_bytes.h"

#include <cereal/archives/portable_binary.hpp>
#include <cereal/types/optional.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/vector.hpp>

#include <boost/crc.hpp>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>

namespace retractor::datasets {
template <class Archive> void serialize(Archive& archive, LabelEdit& edit)
{
    archive(edit.what, edit.voxels, edit.before, edit.after);
}
} // namespace retractor::datasets

namespace retractor::planner {

template <class Archive> void serialize(Archive& archive, NameCorrection& names)
{
    archive(names.kind, names.name, names.other, names.material, names.role);
}
template <class Archive> void serialize(Archive& archive, LabelStep& step)
{
    archive(step.what, step.edits, step.names);
}

namespace {

    // A change of what is stored needs another mark.
    constexpr std::string_view kMark = "retractor unsaved labels 1\n";

} // namespace

std::filesystem::path unsaved_labels_file(const Case& planned_case)
{
    return planned_case.file().replace_extension(".unsaved-labels");
}

std::uint32_t sum_of(const mesh::LabelVolume& labels)
{
    boost::crc_32_type sum;
    sum.process_bytes(labels.voxels.data(), labels.voxels.size() * sizeof(Label));
    for (const mesh::LabelInfo& info : labels.table) {
        sum.process_bytes(&info.id, sizeof info.id);
        sum.process_bytes(info.name.data(), info.name.size());
    }
    return sum.checksum();
}

void write_unsaved_labels(
    const std::filesystem::path& file, std::uint32_t sum_of_labels, const std::vector<LabelStep>& steps)
{
    if (steps.empty()) {
        std::error_code code;
        std::filesystem::remove(file, code);
        if (code)
            throw IoError("cannot be removed: " + code.message(), file.string());
        return;
    }
    std::ostringstream archived(std::ios::binary);
    {
        cereal::PortableBinaryOutputArchive archive(archived);
        archive(sum_of_labels, steps);
    }
    write_file_atomically(file, with_sum(kMark, archived.str()));
}

std::optional<std::vector<LabelStep>> read_unsaved_labels(
    const std::filesystem::path& file, std::uint32_t sum_of_labels)
{
    std::error_code code;
    if (!std::filesystem::exists(file, code))
        return std::nullopt;
    std::ifstream in(file, std::ios::binary);
    const std::string content(std::istreambuf_iterator<char>(in), {});
    if (in.bad() || !in.is_open())
        throw IoError("cannot be read", file.string());
    const std::optional<std::string_view> bytes = without_sum(kMark, content);
    if (!bytes)
        throw InputError("these unsaved corrections of labels are damaged", file.string());
    std::istringstream archived(std::string(*bytes), std::ios::binary);
    try {
        cereal::PortableBinaryInputArchive archive(archived);
        std::uint32_t sum = 0;
        std::vector<LabelStep> steps;
        archive(sum, steps);
        if (sum != sum_of_labels)
            throw InputError(
                "unsaved corrections were made on labels that have changed since, and cannot be made again",
                file.string());
        return steps;
    } catch (const cereal::Exception& exception) {
        throw InputError(
            std::string("these unsaved corrections of labels are damaged (") + exception.what() + ")", file.string());
    }
}

} // namespace retractor::planner
