// A slider that keeps its own place: what the server answers to a move comes after later ones, and would take them back.
export default {
  template: `<q-slider v-model="now" @update:model-value="$emit('moved', $event)" />`,
  props: { start: Number },
  emits: ["moved"],
  data() {
    return { now: this.start };
  },
};
