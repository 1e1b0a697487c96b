#include "datasets/io/byte_source.h"

#include "datasets/io/voxel_values.h"
#include "mesh/base/error.h"

#include <bzlib.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>

namespace retractor::datasets {

namespace {

    constexpr std::size_t kBuffer = 1U << 18U;
    const char* const kDamaged = "the compressed data are damaged or cut short";

    class FileSource final : public ByteSource {
    public:
        FileSource(const std::filesystem::path& path, std::uint64_t start, std::uint64_t length)
            : file_(path, std::ios::binary)
            , left_(length)
            , path_(path.string())
        {
            if (!file_ || !file_.seekg(static_cast<std::streamoff>(start)))
                throw IoError("cannot open the file", path_);
        }
        std::size_t read(char* out, std::size_t count) override
        {
            file_.read(out, static_cast<std::streamsize>(std::min<std::uint64_t>(count, left_)));
            if (file_.bad())
                throw IoError("cannot read the file", path_);
            const auto got = static_cast<std::size_t>(file_.gcount());
            left_ -= got;
            return got;
        }

    private:
        std::ifstream file_;
        std::uint64_t left_;
        std::string path_;
    };

    /// Reads encoded bytes from another source, one buffer at a time.
    class InputBuffer {
    public:
        InputBuffer(std::unique_ptr<ByteSource> source, std::string name)
            : where(std::move(name))
            , source_(std::move(source))
        {
        }
        std::size_t refill() { return source_->read(bytes.data(), bytes.size()); }
        /// The next byte, or -1 at the end.
        int next()
        {
            if (at_ == filled_) {
                filled_ = refill();
                at_ = 0;
                if (filled_ == 0)
                    return -1;
            }
            return static_cast<unsigned char>(bytes[at_++]);
        }
        int next_not_blank()
        {
            int c = next();
            while (is_blank(c))
                c = next();
            return c;
        }
        static bool is_blank(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

        std::vector<char> bytes = std::vector<char>(kBuffer);
        std::string where;

    private:
        std::unique_ptr<ByteSource> source_;
        std::size_t at_ = 0;
        std::size_t filled_ = 0;
    };

    class Base64Source final : public ByteSource {
    public:
        explicit Base64Source(InputBuffer input)
            : input_(std::move(input))
        {
        }
        std::size_t read(char* out, std::size_t count) override
        {
            std::size_t done = 0;
            for (; done < count; ++done) {
                if (at_ == filled_ && !next_four())
                    break;
                out[done] = three_[at_++];
            }
            return done;
        }

    private:
        bool next_four()
        {
            std::uint32_t bits = 0;
            std::size_t digits = 0;
            std::size_t padding = 0;
            for (std::size_t n = 0; n < 4; ++n) {
                const int c = input_.next_not_blank();
                if (c < 0 && n == 0)
                    return false;
                const int value = c == '=' && n >= 2 ? 0 : digit(c);
                padding += c == '=' ? 1 : 0;
                if (value < 0 || (padding > 0 && c != '='))
                    throw InputError("the base64 data are damaged or cut short", input_.where);
                bits = bits << 6U | static_cast<std::uint32_t>(value);
                ++digits;
            }
            for (std::size_t n = 0; n < 3; ++n)
                three_[n] = static_cast<char>(bits >> (16 - 8 * n) & 0xffU);
            at_ = 0;
            filled_ = 3 - padding;
            return true;
        }
        static int digit(int c)
        {
            if (c >= 'A' && c <= 'Z')
                return c - 'A';
            if (c >= 'a' && c <= 'z')
                return c - 'a' + 26;
            if (c >= '0' && c <= '9')
                return c - '0' + 52;
            return c == '+' ? 62 : c == '/' ? 63 : -1;
        }

        InputBuffer input_;
        std::array<char, 3> three_ {};
        std::size_t at_ = 0;
        std::size_t filled_ = 0;
    };

    /// Inflates zlib or gzip. Several gzip members form one stream, as for the program gzip.
    class InflateSource final : public ByteSource {
    public:
        InflateSource(InputBuffer input, std::uint64_t streams)
            : input_(std::move(input))
            , streams_left_(streams)
        {
            constexpr int kAnyFormat = 15 + 32; // largest window; zlib and gzip headers are both accepted
            if (inflateInit2(&stream_, kAnyFormat) != Z_OK)
                throw IoError("cannot start decompression", input_.where);
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
                    throw InputError(kDamaged, input_.where);
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
            const bool counted = streams_left_ > 1;
            streams_left_ -= counted ? 1 : 0;
            const bool member = streams_left_ == 0 && stream_.avail_in > 0 && *stream_.next_in == kGzipMagic;
            if ((counted || member) && inflateReset(&stream_) == Z_OK)
                return;
            leftover_ = stream_.avail_in > 0;
            ended_ = true;
        }

        InputBuffer input_;
        std::uint64_t streams_left_;
        z_stream stream_ {};
        bool ended_ = false;
        bool leftover_ = false;
    };

    class Bzip2Source final : public ByteSource {
    public:
        explicit Bzip2Source(InputBuffer input)
            : input_(std::move(input))
        {
            if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK)
                throw IoError("cannot start decompression", input_.where);
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
                    // The decoder may still hold output. When the data are cut, the decoder makes no output without
                    // input.
                    if (stream_.avail_in == 0 && exhausted_)
                        throw InputError(kDamaged, input_.where);
                    exhausted_ = stream_.avail_in == 0;
                }
                const int status = BZ2_bzDecompress(&stream_);
                ended_ = status == BZ_STREAM_END;
                if (status != BZ_OK && !ended_)
                    throw InputError(kDamaged, input_.where);
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

    class HexSource final : public ByteSource {
    public:
        explicit HexSource(InputBuffer input)
            : input_(std::move(input))
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
                    throw InputError("the hexadecimal data end inside a byte", input_.where);
                out[n] = static_cast<char>(high * 16 + low);
            }
            return count;
        }

    private:
        int digit()
        {
            int c = input_.next_not_blank();
            if (c < 0)
                return -1;
            if (c >= '0' && c <= '9')
                return c - '0';
            const int letter = c | 0x20;
            if (letter >= 'a' && letter <= 'f')
                return letter - 'a' + 10;
            throw InputError("the hexadecimal data have a character that is no digit", input_.where);
        }
        InputBuffer input_;
    };

    class TextSource final : public ByteSource {
    public:
        TextSource(InputBuffer input, VoxelType type)
            : input_(std::move(input))
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
            int c = input_.next_not_blank();
            if (c < 0)
                return false;
            std::string word;
            for (; c >= 0 && !InputBuffer::is_blank(c) && word.size() <= kLongest; c = input_.next())
                word.push_back(static_cast<char>(c));
            const std::size_t sign = word.starts_with('+') ? 1 : 0;
            with_voxel_type(type_, [&](auto value) {
                const auto [end, error] = std::from_chars(word.data() + sign, word.data() + word.size(), value);
                if (error != std::errc() || end != word.data() + word.size() || word.size() > kLongest) {
                    std::replace_if(
                        word.begin(), word.end(), [](char x) { return x < '!' || x > '~'; }, '?');
                    throw InputError(
                        "the text data have \"" + word + "\" where a number of the voxels' type must be", input_.where);
                }
                pending_.resize(sizeof(value));
                std::memcpy(pending_.data(), &value, sizeof(value));
            });
            pending_at_ = 0;
            return true;
        }

        InputBuffer input_;
        VoxelType type_;
        std::vector<char> pending_;
        std::size_t pending_at_ = 0;
    };

} // namespace

std::unique_ptr<ByteSource> open_source(const EncodedBytes& bytes)
{
    const std::string where = bytes.file.string();
    std::unique_ptr<ByteSource> source = std::make_unique<FileSource>(bytes.file, bytes.start, bytes.length);
    if (bytes.base64)
        source = std::make_unique<Base64Source>(InputBuffer(std::move(source), where));
    if (bytes.encoding == Encoding::raw)
        return source;
    InputBuffer input(std::move(source), where);
    switch (bytes.encoding) {
    case Encoding::deflate:
        return std::make_unique<InflateSource>(std::move(input), bytes.streams);
    case Encoding::bzip2:
        return std::make_unique<Bzip2Source>(std::move(input));
    case Encoding::text:
        return std::make_unique<TextSource>(std::move(input), bytes.type);
    default:
        return std::make_unique<HexSource>(std::move(input));
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

} // namespace retractor::datasets
