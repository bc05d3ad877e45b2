#include "image/jpeg.h"

#include <cstdio>
// jpeglib.h needs FILE from this header.
#include <jerror.h>
#include <jpeglib.h>

#include <cassert>
#include <csetjmp>
#include <cstdlib>

#include "base/error.h"
#include "image/formats.h"

namespace skywave {
namespace {

// libjpeg ends the program on errors unless its handler is replaced by one that does not return.
struct Errors {
  jpeg_error_mgr base;  // comes first because libjpeg passes back a pointer to it
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

void Jump(j_common_ptr info) {
  auto* errors = reinterpret_cast<Errors*>(info->err);
  info->err->format_message(info, errors->message);
  std::longjmp(errors->jump, 1);
}

// Warnings report truncated or damaged data, after which libjpeg would continue with grey; but not
// these, after which every pixel is there.
void EmitMessage(j_common_ptr info, int level) {
  if (level >= 0) return;
  for (const int harmless : {JWRN_EXTRANEOUS_DATA, JWRN_JFIF_MAJOR, JWRN_ADOBE_XFORM}) {
    if (info->err->msg_code == harmless) return;
  }
  Jump(info);
}

// Without this limit, a small progressive file could demand any number of passes over all pixels.
constexpr int kMaxScans = 200;
void CheckScans(j_common_ptr info) {
  auto* decoder = reinterpret_cast<j_decompress_ptr>(info);
  if (decoder->input_scan_number <= kMaxScans) return;
  auto* errors = reinterpret_cast<Errors*>(info->err);
  std::snprintf(errors->message, sizeof errors->message, "more than %d scans", kMaxScans);
  std::longjmp(errors->jump, 1);
}

// No object with a destructor may be created between setjmp and longjmp, so the two halves of
// decoding are plain functions that return false on errors.
bool ReadHeader(jpeg_decompress_struct& decoder, Errors& errors, std::string_view bytes) {
  if (setjmp(errors.jump)) return false;
  jpeg_create_decompress(&decoder);
  jpeg_mem_src(&decoder, reinterpret_cast<const unsigned char*>(bytes.data()),
               static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&decoder, TRUE);
  return true;
}

bool ReadPixels(jpeg_decompress_struct& decoder, Errors& errors, jpeg_progress_mgr& progress,
                std::uint8_t* pixels) {
  if (setjmp(errors.jump)) return false;
  decoder.progress = &progress;
  decoder.out_color_space = JCS_RGB;
  decoder.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&decoder);
  const std::size_t stride = std::size_t{decoder.output_width} * 3;
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW row = pixels + stride * decoder.output_scanline;
    jpeg_read_scanlines(&decoder, &row, 1);
  }
  jpeg_finish_decompress(&decoder);
  return true;
}

// Writes into a buffer of libjpeg, which belongs to the caller afterwards.
bool WritePixels(jpeg_compress_struct& encoder, Errors& errors, const std::uint8_t* rgb,
                 int quality, unsigned char*& buffer, unsigned long& size) {
  if (setjmp(errors.jump)) return false;
  jpeg_mem_dest(&encoder, &buffer, &size);
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, quality, TRUE);
  encoder.dct_method = JDCT_ISLOW;
  jpeg_start_compress(&encoder, TRUE);
  const std::size_t stride = std::size_t{encoder.image_width} * 3;
  while (encoder.next_scanline < encoder.image_height) {
    auto* row = const_cast<JSAMPROW>(rgb + stride * encoder.next_scanline);
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
  return true;
}

}  // namespace

std::string EncodeJpeg(int width, int height, const std::vector<std::uint8_t>& rgb, int quality) {
  assert(rgb.size() == std::size_t(width) * std::size_t(height) * 3);
  Errors errors = {};
  jpeg_compress_struct encoder = {};
  encoder.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = Jump;
  jpeg_create_compress(&encoder);
  encoder.image_width = JDIMENSION(width), encoder.image_height = JDIMENSION(height);
  encoder.input_components = 3, encoder.in_color_space = JCS_RGB;
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  const bool written = WritePixels(encoder, errors, rgb.data(), quality, buffer, size);
  jpeg_destroy_compress(&encoder);
  std::string bytes;
  if (written) bytes.assign(reinterpret_cast<const char*>(buffer), size);
  std::free(buffer);
  if (!written) {
    throw InputError(InputPosition::File("JPEG"),
                     std::string("the picture cannot be encoded: ") + errors.message, kExitIo);
  }
  return bytes;
}

CompactImage DecodeJpeg(const std::string& path, std::string_view bytes, Encoding encoding,
                        const ReadLimits& limits) {
  jpeg_decompress_struct decoder = {};
  struct Destroy {
    jpeg_decompress_struct* decoder;
    ~Destroy() { jpeg_destroy_decompress(decoder); }
  } const destroy_at_end{&decoder};
  Errors errors = {};
  decoder.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = Jump;
  errors.base.emit_message = EmitMessage;
  const auto fail = [&](const std::string& reason) {
    throw InputError(InputPosition::File(path), "is no JPEG to read: " + reason);
  };
  if (!ReadHeader(decoder, errors, bytes)) fail(errors.message);
  CheckSize(InputPosition::File(path), decoder.image_width, decoder.image_height, limits);
  if (decoder.num_components != 1 && decoder.num_components != 3) {
    fail("it has " + std::to_string(decoder.num_components) + " channels");
  }
  std::vector<std::uint8_t> pixels(std::size_t{decoder.image_width} * decoder.image_height * 3);
  jpeg_progress_mgr progress = {};
  progress.progress_monitor = CheckScans;
  if (!ReadPixels(decoder, errors, progress, pixels.data())) fail(errors.message);
  return CompactImage(int(decoder.image_width), int(decoder.image_height), std::move(pixels),
                      encoding);
}

}  // namespace skywave
