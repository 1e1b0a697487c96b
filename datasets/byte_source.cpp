#include "datasets/byte_source.h"

#include "datasets/header_text.h"
#include "datasets/voxel_values.h"
#include "mesh/base/error.h"

#include <bzlib.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>

namespace retractor {

namespace {

    constexpr std::size_t kBuffer = 1U << 18U;
    const char* const kDamaged = "the compressed data are damaged or cut short";

    class FileSource final : public ByteSource {
    public:
        FileSource(const std::filesystem::path& path, std::uint64_t start)
            : file_(path, std::ios::binary)
            , path_(path.string())
        {
            if (!file_ || !file_.seekg(static_cast<std::streamoff>(start)))
                throw IoError("cannot open the file", path_);
        }
        std::size_t read(char* out, std::size_t count) override
        {
            file_.read(out, static_cast<std::streamsize>(count));
            if (file_.bad())
                throw IoError("cannot read the file", path_);
            return static_cast<std::size_t>(file_.gcount());
        }
        const std::string& path() const { return path_; }

    private:
        std::ifstream file_;
        std::string path_;
    };

    /// Compressed bytes as they come from the file, one buffer at a time.
    struct InputBuffer {
        FileSource file;
        std::vector<char> bytes = std::vector<char>(kBuffer);

        std::size_t refill() { return file.read(bytes.data(), bytes.size()); }
    };

    /// gzip (several members one after the other are one stream, as gzip itself reads them) or zlib.
    class InflateSource final : public ByteSource {
    public:
        InflateSource(const std::filesystem::path& path, std::uint64_t start)
            : input_ { FileSource(path, start) }
        {
            constexpr int kAnyFormat = 15 + 32; // largest window, zlib or gzip header
            if (inflateInit2(&stream_, kAnyFormat) != Z_OK)
                throw IoError("cannot start decompression", path.string());
        }
        ~InflateSource() override { inflateEnd(&stream_); }

        std::size_t read(char* out, std::size_t count) override
        {
            stream_.next_out = reinterpret_cast<Bytef*>(out);
            stream_.avail_out = static_cast<uInt>(std::min<std::size_t>(count, std::numeric_limits<uInt>::max()));
            const uInt wanted = stream_.avail_out;
            while (stream_.avail_out > 0 && !ended_) {
                refill();
                const int status = inflate(&stream_, Z_NO_FLUSH);
                if (status == Z_STREAM_END)
                    next_member();
                else if (status != Z_OK)
                    throw InputError(kDamaged, input_.file.path());
            }
            return wanted - stream_.avail_out;
        }
        bool has_leftover() const override { return leftover_; }

    private:
        void refill()
        {
            if (stream_.avail_in > 0)
                return;
            stream_.avail_in = static_cast<uInt>(input_.refill());
            stream_.next_in = reinterpret_cast<Bytef*>(input_.bytes.data());
        }
        void next_member()
        {
            constexpr Bytef kGzipMagic = 0x1f;
            refill();
            if (stream_.avail_in > 0 && *stream_.next_in == kGzipMagic && inflateReset(&stream_) == Z_OK)
                return;
            leftover_ = stream_.avail_in > 0;
            ended_ = true;
        }

        InputBuffer input_;
        z_stream stream_ {};
        bool ended_ = false;
        bool leftover_ = false;
    };

    class Bzip2Source final : public ByteSource {
    public:
        Bzip2Source(const std::filesystem::path& path, std::uint64_t start)
            : input_ { FileSource(path, start) }
        {
            if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK)
                throw IoError("cannot start decompression", path.string());
        }
        ~Bzip2Source() override { BZ2_bzDecompressEnd(&stream_); }

        std::size_t read(char* out, std::size_t count) override
        {
            stream_.next_out = out;
            stream_.avail_out = static_cast<unsigned>(std::min<std::size_t>(count, std::numeric_limits<int>::max()));
            const unsigned wanted = stream_.avail_out;
            while (stream_.avail_out > 0 && !ended_) {
                if (stream_.avail_in == 0) {
                    stream_.avail_in = static_cast<unsigned>(input_.refill());
                    stream_.next_in = input_.bytes.data();
                    // The decoder may still hold output; without input it makes none at a cut.
                    if (stream_.avail_in == 0 && exhausted_)
                        throw InputError(kDamaged, input_.file.path());
                    exhausted_ = stream_.avail_in == 0;
                }
                const int status = BZ2_bzDecompress(&stream_);
                ended_ = status == BZ_STREAM_END;
                if (status != BZ_OK && !ended_)
                    throw InputError(kDamaged, input_.file.path());
            }
            return wanted - stream_.avail_out;
        }
        bool has_leftover() const override { return ended_ && stream_.avail_in > 0; }

    private:
        InputBuffer input_;
        bz_stream stream_ {};
        bool ended_ = false;
        bool exhausted_ = false;
    };

    /// Numbers or digits in text, one word at a time.
    class WordReader {
    public:
        WordReader(const std::filesystem::path& path, std::uint64_t start)
            : input_ { FileSource(path, start) }
        {
        }
        /// The next character, or -1 at the end.
        int character()
        {
            if (at_ == filled_) {
                filled_ = input_.refill();
                at_ = 0;
                if (filled_ == 0)
                    return -1;
            }
            return static_cast<unsigned char>(input_.bytes[at_++]);
        }
        const std::string& path() const { return input_.file.path(); }

    private:
        InputBuffer input_;
        std::size_t at_ = 0;
        std::size_t filled_ = 0;
    };

    bool is_blank(int c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }

    class HexSource final : public ByteSource {
    public:
        HexSource(const std::filesystem::path& path, std::uint64_t start)
            : words_(path, start)
        {
        }
        std::size_t read(char* out, std::size_t count) override
        {
            for (std::size_t n = 0; n < count; ++n) {
                const int high = digit();
                if (high < 0)
                    return n;
                const int low = digit();
                if (low < 0)
                    throw InputError("the hexadecimal data end inside a byte", words_.path());
                out[n] = static_cast<char>(high * 16 + low);
            }
            return count;
        }

    private:
        int digit()
        {
            int c = words_.character();
            while (is_blank(c))
                c = words_.character();
            if (c < 0)
                return -1;
            if (c >= '0' && c <= '9')
                return c - '0';
            const int letter = c | 0x20;
            if (letter >= 'a' && letter <= 'f')
                return letter - 'a' + 10;
            throw InputError("the hexadecimal data have a character that is no digit", words_.path());
        }
        WordReader words_;
    };

    class TextSource final : public ByteSource {
    public:
        TextSource(const std::filesystem::path& path, std::uint64_t start, VoxelType type)
            : words_(path, start)
            , type_(type)
        {
        }
        std::size_t read(char* out, std::size_t count) override
        {
            std::size_t done = 0;
            while (done < count) {
                if (pending_at_ == pending_.size() && !next_number())
                    break;
                const std::size_t n = std::min(count - done, pending_.size() - pending_at_);
                std::memcpy(out + done, pending_.data() + pending_at_, n);
                pending_at_ += n;
                done += n;
            }
            return done;
        }

    private:
        bool next_number()
        {
            constexpr std::size_t kLongest = 64;
            int c = words_.character();
            while (is_blank(c))
                c = words_.character();
            if (c < 0)
                return false;
            std::string word;
            for (; c >= 0 && !is_blank(c) && word.size() < kLongest; c = words_.character())
                word.push_back(static_cast<char>(c));
            const std::size_t sign = word.starts_with('+') ? 1 : 0;
            with_voxel_type(type_, [&](auto value) {
                const auto [end, error] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
                if (error != std::errc() || end != word.data() + word.size()) {
                    std::replace_if(
                        word.begin(), word.end(), [](char x) { return x < '!' || x > '~'; }, '?');
                    throw InputError("the text data have \"" + word + "\" where a number of the voxels' type must be",
                        words_.path());
                }
                pending_.resize(sizeof(value));
                std::memcpy(pending_.data(), &value, sizeof(value));
            });
            pending_at_ = 0;
            return true;
        }

        WordReader words_;
        VoxelType type_;
        std::vector<char> pending_;
        std::size_t pending_at_ = 0;
    };

} // namespace

std::unique_ptr<ByteSource> open_source(
    const std::filesystem::path& file, std::uint64_t start, Encoding encoding, VoxelType type)
{
    switch (encoding) {
    case Encoding::deflate:
        return std::make_unique<InflateSource>(file, start);
    case Encoding::bzip2:
        return std::make_unique<Bzip2Source>(file, start);
    case Encoding::text:
        return std::make_unique<TextSource>(file, start, type);
    case Encoding::hex:
        return std::make_unique<HexSource>(file, start);
    default:
        return std::make_unique<FileSource>(file, start);
    }
}

std::uint64_t skip(ByteSource& source, std::uint64_t count)
{
    std::vector<char> dropped(std::min<std::uint64_t>(count, kBuffer));
    std::uint64_t done = 0;
    while (done < count) {
        const std::size_t got = source.read(dropped.data(), std::min<std::uint64_t>(count - done, dropped.size()));
        if (got == 0)
            break;
        done += got;
    }
    return done;
}

} // namespace retractor
