# Campaigns on one machine: each stage is a rule, and what did not change is not done again.
#
#   make -f fleet/campaigns.mk -j IN=campaigns OUT=results                       documents of campaigns, campaigns/*.json
#   make -f fleet/campaigns.mk -j PLAN=plan.json SEEDS="$(seq 1 1000)" OUT=results    campaigns that are simulated
#
# The result of a stage stands in OUT/STAGE/NAME.json. A stage is done again for a campaign when what it reads or the program itself has
# changed; where it then writes the same bytes, nothing after it is done. `make … report` makes the pages.

STAGES ?= coilcal sensorcal axescal
BIN ?= target/release
OUT ?= results
SHELL := /bin/sh
.DELETE_ON_ERROR:
.SECONDARY:

ifdef PLAN
first := simulate
names := $(addprefix seed-,$(SEEDS))
else
first := given
names := $(patsubst $(IN)/%.json,%,$(wildcard $(IN)/*.json))
endif
last := $(lastword $(first) $(STAGES))

.PHONY: all report
all: $(names:%=$(OUT)/$(last)/%.json)
report: $(names:%=$(OUT)/report/%.html)

# What a stage writes is compared with what is there, which keeps its time when it is the same; that the stage was done is noted apart.
define done
@mkdir -p $(OUT)/$(1)
@echo "$(1) $*"
@$(2) -o $(OUT)/$(1)/$*.new
@if cmp -s $(OUT)/$(1)/$*.new $(OUT)/$(1)/$*.json; then rm $(OUT)/$(1)/$*.new; else mv $(OUT)/$(1)/$*.new $(OUT)/$(1)/$*.json; fi
@mkdir -p $(@D)
@touch $@
endef

# $(call stage,STAGE,the one before)
define stage
$(OUT)/.done/$(1)/%: $(OUT)/$(2)/%.json $(BIN)/$(1)
	$$(call done,$(1),$(BIN)/$(1) -q $$<)
$(OUT)/$(1)/%.json: $(OUT)/.done/$(1)/%
	@:
endef

before := $(first)
$(foreach one,$(STAGES),$(eval $(call stage,$(one),$(before)))$(eval before := $(one)))

$(OUT)/.done/given/%: $(IN)/%.json
	@mkdir -p $(OUT)/given
	@cmp -s $< $(OUT)/given/$*.json || cp $< $(OUT)/given/$*.json
	@mkdir -p $(@D)
	@touch $@
$(OUT)/given/%.json: $(OUT)/.done/given/%
	@:

$(OUT)/.done/simulate/%: $(PLAN) $(BIN)/simulate
	$(call done,simulate,$(BIN)/simulate campaign -q --seed $(patsubst seed-%,%,$*) $(PLAN))
$(OUT)/simulate/%.json: $(OUT)/.done/simulate/%
	@:

$(OUT)/report/%.html: $(OUT)/$(last)/%.json $(BIN)/report
	@mkdir -p $(@D)
	@echo "report $*"
	@$(BIN)/report -q $< -o $@
