#include "ui/movie/video_file.h"

#include "mesh/base/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <string>

namespace retractor::ui {

namespace {

    /// Quality of VP9, from 0 (best) to 63: letters and thin lines stay sharp.
    constexpr const char* kQuality = "24";
    /// Speed of VP9, from 0 (slowest) to 8.
    constexpr const char* kSpeed = "6";
    /// A player can begin at a picture that is whole; there is one in so many seconds.
    constexpr int kWholePictureS = 2;

    std::string reason_of(int code)
    {
        char text[AV_ERROR_MAX_STRING_SIZE] {};
        return av_strerror(code, text, sizeof text) == 0 ? text : "error " + std::to_string(code);
    }

    struct Deleter {
        void operator()(AVFormatContext* format) const
        {
            if (format->pb != nullptr)
                avio_closep(&format->pb);
            avformat_free_context(format);
        }
        void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
        void operator()(AVFrame* frame) const { av_frame_free(&frame); }
        void operator()(AVPacket* packet) const { av_packet_free(&packet); }
        void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
    };
    template <class T> using Owned = std::unique_ptr<T, Deleter>;

} // namespace

struct VideoFile::State {
    std::string name;
    Owned<AVFormatContext> format;
    Owned<AVCodecContext> codec;
    Owned<AVFrame> frame;
    Owned<AVPacket> packet;
    Owned<SwsContext> scaler;
    AVStream* stream = nullptr; ///< of the format
    std::int64_t frames = 0;

    void check(int code, const char* what) const
    {
        if (code < 0)
            throw IoError(std::string(what) + ": " + reason_of(code), name);
    }

    void set(const char* option, const char* value) const
    {
        check(av_opt_set(codec->priv_data, option, value, 0), "the encoder of VP9 does not know its options");
    }

    void open_codec(int width, int height, int frames_per_second)
    {
        const AVCodec* vp9 = avcodec_find_encoder_by_name("libvpx-vp9");
        if (vp9 == nullptr)
            throw IoError("this machine's FFmpeg has no encoder of VP9", name);
        codec.reset(avcodec_alloc_context3(vp9));
        codec->width = width;
        codec->height = height;
        codec->time_base = { 1, frames_per_second };
        codec->framerate = { frames_per_second, 1 };
        codec->pix_fmt = AV_PIX_FMT_YUV420P;
        codec->color_range = AVCOL_RANGE_MPEG;
        codec->colorspace = AVCOL_SPC_BT709;
        codec->color_primaries = AVCOL_PRI_BT709;
        codec->color_trc = AVCOL_TRC_IEC61966_2_1;
        codec->gop_size = kWholePictureS * frames_per_second;
        codec->bit_rate = 0; // the quality decides
        codec->thread_count = 2;
        codec->flags |= AV_CODEC_FLAG_BITEXACT;
        set("crf", kQuality);
        set("deadline", "good");
        set("cpu-used", kSpeed);
        set("row-mt", "1");
        check(avcodec_open2(codec.get(), vp9, nullptr), "the encoder of VP9 cannot be started");
    }

    void open_file()
    {
        AVFormatContext* made = nullptr;
        check(avformat_alloc_output_context2(&made, nullptr, "webm", name.c_str()), "a movie cannot be begun");
        format.reset(made);
        format->flags |= AVFMT_FLAG_BITEXACT; // no time and no name of a program
        stream = avformat_new_stream(format.get(), nullptr);
        if (stream == nullptr)
            throw IoError("a movie cannot be begun: out of memory", name);
        stream->time_base = codec->time_base;
        stream->avg_frame_rate = codec->framerate;
        check(avcodec_parameters_from_context(stream->codecpar, codec.get()), "a movie cannot be begun");
        check(avio_open(&format->pb, name.c_str(), AVIO_FLAG_WRITE), "the movie cannot be opened for writing");
        check(avformat_write_header(format.get(), nullptr), "the movie's beginning cannot be written");
    }

    void make_frame()
    {
        frame.reset(av_frame_alloc());
        packet.reset(av_packet_alloc());
        frame->format = codec->pix_fmt;
        frame->width = codec->width;
        frame->height = codec->height;
        frame->color_range = codec->color_range;
        frame->colorspace = codec->colorspace;
        check(av_frame_get_buffer(frame.get(), 0), "a movie cannot be begun");
        scaler.reset(sws_getContext(codec->width, codec->height, AV_PIX_FMT_RGB24, codec->width, codec->height,
            codec->pix_fmt, SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
        if (scaler == nullptr)
            throw IoError("a movie of this size cannot be made", name);
        const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
        constexpr int kWhole = 1, kLimited = 0, kContrast = 1 << 16, kSaturation = 1 << 16;
        sws_setColorspaceDetails(scaler.get(), bt709, kWhole, bt709, kLimited, 0, kContrast, kSaturation);
    }

    /// Hands a frame to the encoder, or nothing at the end, and writes what the encoder gives back.
    void encode(const AVFrame* given)
    {
        check(avcodec_send_frame(codec.get(), given), "a picture of the movie cannot be encoded");
        for (;;) {
            const int code = avcodec_receive_packet(codec.get(), packet.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF)
                return;
            check(code, "a picture of the movie cannot be encoded");
            packet->duration = 1;
            av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
            packet->stream_index = stream->index;
            check(av_interleaved_write_frame(format.get(), packet.get()), "the movie cannot be written");
        }
    }
};

VideoFile::VideoFile(const std::filesystem::path& path, int width, int height, int frames_per_second)
    : state_(std::make_unique<State>())
{
    if (width < 2 || height < 2 || width % 2 != 0 || height % 2 != 0)
        throw InputError("a movie needs an even width and an even height, not " + std::to_string(width) + " x "
            + std::to_string(height));
    if (frames_per_second < 1)
        throw InputError("a movie needs at least one frame per second");
    av_log_set_level(AV_LOG_QUIET); // failures are thrown
    state_->name = path.string();
    state_->open_codec(width, height, frames_per_second);
    state_->open_file();
    state_->make_frame();
}

VideoFile::~VideoFile() = default;

void VideoFile::add(const Image& image, int frames)
{
    State& s = *state_;
    if (image.width != s.codec->width || image.height != s.codec->height)
        throw InputError("all pictures of a movie have one size");
    s.check(av_frame_make_writable(s.frame.get()), "a picture of the movie cannot be encoded");
    const std::uint8_t* const from[] = { image.rgb.data() };
    const int stride[] = { 3 * image.width };
    sws_scale(s.scaler.get(), from, stride, 0, image.height, s.frame->data, s.frame->linesize);
    for (int n = 0; n < frames; ++n) {
        s.frame->pts = s.frames++;
        s.encode(s.frame.get());
    }
}

void VideoFile::finish()
{
    State& s = *state_;
    s.encode(nullptr);
    s.check(av_write_trailer(s.format.get()), "the movie's end cannot be written");
    s.check(avio_closep(&s.format->pb), "the movie cannot be closed");
}

} // namespace retractor::ui
