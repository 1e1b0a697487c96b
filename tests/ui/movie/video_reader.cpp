#include "tests/ui/movie/video_reader.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <cstdlib>
#include <stdexcept>

namespace retractor::test_support {

namespace {

    void check(bool good, const char* what)
    {
        if (!good)
            throw std::runtime_error(what);
    }

    ui::Image rgb_of(const AVFrame& frame)
    {
        ui::Image image { .width = frame.width, .height = frame.height, .rgb = {} };
        image.rgb.resize(3UL * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
        SwsContext* scaler = sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format),
            frame.width, frame.height, AV_PIX_FMT_RGB24, SWS_BILINEAR | SWS_ACCURATE_RND, nullptr, nullptr, nullptr);
        const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
        sws_setColorspaceDetails(scaler, bt709, 0, bt709, 1, 0, 1 << 16, 1 << 16);
        std::uint8_t* const to[] = { image.rgb.data() };
        const int stride[] = { 3 * frame.width };
        sws_scale(scaler, frame.data, frame.linesize, 0, frame.height, to, stride);
        sws_freeContext(scaler);
        return image;
    }

} // namespace

ReadVideo read_video(const std::filesystem::path& path)
{
    AVFormatContext* format = nullptr;
    check(avformat_open_input(&format, path.c_str(), nullptr, nullptr) == 0, "the file is no movie");
    check(avformat_find_stream_info(format, nullptr) >= 0 && format->nb_streams == 1, "the file has no one stream");
    const AVStream& stream = *format->streams[0];
    const AVCodec* decoder = avcodec_find_decoder(stream.codecpar->codec_id);
    check(decoder != nullptr, "there is no decoder");
    AVCodecContext* codec = avcodec_alloc_context3(decoder);
    check(avcodec_parameters_to_context(codec, stream.codecpar) >= 0 && avcodec_open2(codec, decoder, nullptr) == 0,
        "the decoder does not start");
    ReadVideo video;
    video.codec = avcodec_get_name(stream.codecpar->codec_id);
    video.format = format->iformat->name;
    video.frames_per_second = av_q2d(stream.avg_frame_rate);
    video.seconds = static_cast<double>(format->duration) / AV_TIME_BASE;
    AVPacket* packet = av_packet_alloc();
    AVFrame* frame = av_frame_alloc();
    const auto receive = [&] {
        while (avcodec_receive_frame(codec, frame) == 0)
            video.frames.push_back(rgb_of(*frame));
    };
    while (av_read_frame(format, packet) == 0) {
        check(avcodec_send_packet(codec, packet) == 0, "a frame cannot be decoded");
        av_packet_unref(packet);
        receive();
    }
    avcodec_send_packet(codec, nullptr);
    receive();
    av_frame_free(&frame);
    av_packet_free(&packet);
    avcodec_free_context(&codec);
    avformat_close_input(&format);
    return video;
}

double mean_difference(const ui::Image& a, const ui::Image& b)
{
    check(a.rgb.size() == b.rgb.size(), "two pictures of different size");
    double sum = 0.0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i)
        sum += std::abs(static_cast<int>(a.rgb[i]) - static_cast<int>(b.rgb[i]));
    return sum / static_cast<double>(a.rgb.size());
}

} // namespace retractor::test_support
