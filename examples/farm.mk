# Renders a picture in parts with GNU make, on as many jobs as -j gives, and adds them up:
#
#     make -f farm.mk -j4 SCENE=gallery SPP=64 OPTIONS="--size 640x480" OUTPUT=gallery.exr
#
# The parts are ranges of samples. A part that was interrupted goes on from its checkpoint, one that
# is there is not rendered again, and the picture has the bytes of a single render.
SKYWAVE ?= skywave
SCENE ?= gallery
SPP ?= 64
PARTS ?= 4
OPTIONS ?= --size 640x480
OUTPUT ?= $(basename $(notdir $(SCENE))).exr
FOLDER ?= $(OUTPUT:.exr=)_parts

numbers := $(shell seq $(PARTS))
films := $(numbers:%=$(FOLDER)/%.film)

$(OUTPUT): $(films)
	$(SKYWAVE) merge $^ -o $@

# Part I of N has samples (I - 1) SPP / N to I SPP / N.
$(FOLDER)/%.film: | $(FOLDER)
	$(SKYWAVE) render $(SCENE) $(OPTIONS) --spp $(SPP) --checkpoint 60 --resume --film $@ \
	  --sample-range $$((($* - 1) * $(SPP) / $(PARTS))):$$(($* * $(SPP) / $(PARTS)))

$(FOLDER):
	mkdir -p $@

.PHONY: clean
clean:
	rm -rf $(FOLDER)
